// The page: its connection to the renderer, and the pictures on the stage.
"use strict";

import { Controls, withNumber } from "./controls.js";
import { Navigation } from "./navigation.js";
import { Panel } from "./panel.js";

const $ = id => document.getElementById(id);
const LATENCIES = 50;  // of which the median is shown
const UNSEEN = new Set(["shown", "visible", "inspect", "guide"]);  // messages that no picture shows

class Stage {
    constructor(page) {
        this.page = page;
        this.images = [];
        this.labels = [];
        this.look = { mode: "split", a: 0, b: 1, split: 0.5, second: false, zoom: 1, x: 0, y: 0 };
        new ResizeObserver(() => this.draw()).observe($("stage"));
    }

    // Pictures that the next draw shows; one for each graph, or their one difference.
    show(images, labels) {
        this.images.forEach(image => image.close());
        Object.assign(this, { images, labels });
        this.draw();
    }

    set(change) {
        Object.assign(this.look, change);
        if ("mode" in change) {
            clearInterval(this.timer);
            if (change.mode === "blink")
                this.timer = setInterval(() => this.set({ second: !this.look.second }), 600);
        }
        for (const button of document.querySelectorAll("[data-mode]"))
            button.ariaPressed = button.dataset.mode === this.look.mode;
        this.draw();
    }

    // [left, right] of each pane, as places in `images`.
    layout() {
        const { mode, a, b, second } = this.look, last = this.images.length - 1;
        const left = Math.min(a, last), right = Math.min(b, last);
        if (mode === "tiles")
            return this.images.map((_, i) => [i]);
        if (left === right)
            return [[left]];
        return mode === "blink" ? [[second ? right : left]] : [[left, right]];
    }

    draw() {
        if (this.images.length === 0)
            return;
        const layout = this.layout(), stage = $("stage");
        stage.classList.toggle("tiles", this.look.mode === "tiles" && layout.length > 1);
        while (stage.childElementCount > layout.length)
            stage.lastChild.remove();
        while (stage.childElementCount < layout.length)
            this.addPane(stage);
        layout.forEach((shown, i) => this.drawPane(stage.children[i], shown));
    }

    addPane(stage) {
        const pane = document.createElement("div");
        pane.className = "pane";
        pane.append(Object.assign(document.createElement("canvas"), { tabIndex: 0, role: "img" }), Object.assign(document.createElement("span"), { className: "left" }),
                    Object.assign(document.createElement("span"), { className: "right" }));
        stage.append(pane);
        this.page.navigation.attach(pane.firstChild);
    }

    drawPane(pane, [left, right]) {
        const { width, height } = this.images[0], canvas = pane.firstChild, s = this.look;
        pane.style.setProperty("--aspect", width / height);
        const across = Math.round(pane.clientWidth * devicePixelRatio), down = Math.round(across * height / width);
        if (canvas.width !== across || canvas.height !== down)
            Object.assign(canvas, { width: across, height: down });
        for (const side of ["x", "y"])
            s[side] = Math.min(1 - 1 / s.zoom, Math.max(0, s[side]));
        const context = canvas.getContext("2d"), splits = right !== undefined;
        this.blit(context, left, 0, splits ? s.split : 1);
        this.drawPath(context, left, 0, splits ? s.split : 1);
        if (splits) {
            this.blit(context, right, s.split, 1);
            this.drawPath(context, right, s.split, 1);
            context.fillStyle = "#fff";
            context.fillRect(s.split * across - devicePixelRatio, 0, 2 * devicePixelRatio, down);
        }
        pane.children[1].textContent = this.labels[left];
        pane.children[2].textContent = splits ? this.labels[right] : "";
        pane.children[2].hidden = !splits;
        canvas.ariaLabel = [left, ...splits ? [right] : []].map(i => this.labels[i]).join(", and ");
    }

    // Draw the part of a picture between two fractions of the canvas's width.
    blit(context, index, from, to) {
        if (to <= from)
            return;
        const { zoom, x, y } = this.look, image = this.images[index], { width, height } = context.canvas;
        context.imageSmoothingEnabled = width < image.width / zoom;
        context.drawImage(image, (x + from / zoom) * image.width, y * image.height, (to - from) / zoom * image.width,
                          image.height / zoom, from * width, 0, (to - from) * width, height);
    }

    // The paths that a pixel of each graph has selected, as long as the view stays.
    showPaths(pixel) {
        const [width, height] = this.page.state.size;
        Object.assign(this, { paths: pixel.paths, pathView: pixel.view_number, pathPixel: [(pixel.x + 0.5) / width, (pixel.y + 0.5) / height] });
        this.draw();
    }

    hasPaths() { return this.paths !== undefined && this.pathView === this.page.view && this.page.state.view !== "difference"; }

    // The pixel, the path's vertices with their numbers, its edges (broken where a sharp bounce between them is not stored) and
    // the direction towards its light. Between two fractions of the canvas's width.
    drawPath(context, index, from, to) {
        if (!this.hasPaths())
            return;
        const { zoom, x, y } = this.look, { width, height } = context.canvas, path = this.paths[index], unit = devicePixelRatio;
        const at = ([u, v]) => [(u - x) * zoom * width, (v - y) * zoom * height];
        const line = (from, to, colour, dash) => {
            context.strokeStyle = colour;
            context.setLineDash(dash.map(part => part * unit));
            context.beginPath();
            context.moveTo(...at(from));
            context.lineTo(...at(to));
            context.stroke();
        };
        context.save();
        context.beginPath();
        context.rect(from * width, 0, (to - from) * width, height);
        context.clip();
        context.lineWidth = 2 * unit;
        context.font = `${12 * unit}px sans-serif`;
        context.setLineDash([]);
        context.strokeStyle = "#fff";
        context.strokeRect(...at(this.pathPixel).map(value => value - 4 * unit), 8 * unit, 8 * unit);
        path?.points.forEach((point, i) => {
            const last = i > 0 ? path.points[i - 1] : path.bounces[0] > 1 ? this.pathPixel : null;
            if (point && last)
                line(last, point, "#0ff", path.bounces[i] - (i > 0 ? path.bounces[i - 1] : 1) > 1 || i === 0 ? [5, 5] : []);
        });
        if (path?.light && path.points.at(-1))
            line(path.points.at(-1), path.light, "#ff0", [2, 3]);
        context.setLineDash([]);
        path?.points.forEach((point, i) => {
            if (!point)
                return;
            context.fillStyle = "#0ff";
            context.beginPath();
            context.arc(...at(point), 4 * unit, 0, 2 * Math.PI);
            context.fill();
            context.strokeStyle = "#000";  // an outline, so that the number is read on any colour
            const number = [`x${path.bounces[i]}`, at(point)[0] + 6 * unit, at(point)[1] - 6 * unit];
            context.strokeText(...number);
            context.fillText(...number);
        });
        context.restore();
    }

    splits() { return this.look.mode === "split" && this.images.length > 1 && this.look.a !== this.look.b; }
}

class Page {
    constructor() {
        this.navigation = new Navigation(this);
        this.stage = new Stage(this);
        this.panel = new Panel($("panel"), this);
        this.sent = new Map();  // id of a message: when it was sent
        this.latencies = [];
        this.arrivals = [];
        this.id = 0;
        this.frames = 0;
        this.filmAsked = 0;  // id of the last message about a film
        this.view = -1;  // number of the newest view that is known
        this.controls = new Controls(() => this.state && this.showState());
        this.bindControls();
        this.connect();
    }

    connect() {
        const scheme = location.protocol === "https:" ? "wss:" : "ws:";
        this.socket = new WebSocket(`${scheme}//${location.host}${location.pathname}live`);
        this.socket.binaryType = "arraybuffer";
        this.socket.onmessage = event => typeof event.data === "string" ? this.receive(JSON.parse(event.data)) : this.receiveFrame(event.data);
        this.socket.onclose = () => this.report("The viewer has ended, or the connection was lost. Load the page again once it runs.");
        document.onvisibilitychange = () => this.send("visible", { on: !document.hidden });
    }

    send(name, more = {}) {
        if (this.socket.readyState !== WebSocket.OPEN)
            return;
        this.socket.send(JSON.stringify({ do: name, id: ++this.id, ...more }));
        if (UNSEEN.has(name))
            return;
        this.sent.set(this.id, performance.now());
        this.controls.asked = this.id;
    }

    receive(message) {
        if (message.error)
            this.report(message.error);
        if (message.refused && this.state) {
            this.controls.answer(message.refused);
            this.showState();
        }
        if (message.note)
            this.report(message.note, "note");
        if (message.pixel) {
            this.know(message.pixel.view_number);
            this.panel.showPixel(message.pixel);
            this.stage.showPaths(message.pixel);
        }
        if (message.guide)
            this.panel.showGuide(message.guide);
        if (message.state) {
            this.you = message.you;
            this.state = message.state;
            this.controls.answer(this.state.seen[this.you] ?? 0);
            this.know(this.state.view_number);
            this.showState();
        }
    }

    // There is a view of that number: what is known of a pixel of an earlier one is marked. An answer may overtake the state.
    know(view) {
        this.view = Math.max(this.view, view);
        this.panel.markPixel(this.view);
    }

    async receiveFrame(data) {
        const length = new DataView(data).getUint32(0, true);
        const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
        let at = 4 + length;
        const blobs = header.sizes.map(size => new Blob([new Uint8Array(data, at, (at += size, size))], { type: "image/jpeg" }));
        const images = await Promise.all(blobs.map(blob => createImageBitmap(blob)));
        this.know(header.view_number);
        if (images.length)
            this.stage.show(images, header.labels);
        this.frames += 1;
        this.header = header;
        this.measure(header);
        this.showTime(header.time);
        this.panel.showFrame(header);
        this.send("shown");
    }

    // The film at hand, if there is one; where the last one is, once it has ended. A short film may begin and end between two states that
    // the page gets.
    showFilm(film, filmed) {
        if (this.filmed !== undefined && this.filmed !== filmed)
            this.report(`the film is in ${filmed}`, "note");
        this.filmed = filmed;
        $("film").textContent = film ? `stop (${film.done} of ${film.count})` : "record";
    }

    measure(header) {
        const now = performance.now(), seen = header.seen[this.you];
        const when = this.sent.get(seen);
        if (when !== undefined)
            this.latencies = [...this.latencies, now - when].slice(-LATENCIES);
        for (const id of [...this.sent.keys()].filter(id => id <= seen))  // refused ones among them
            this.sent.delete(id);
        this.arrivals = [...this.arrivals, now].filter(when => when > now - 2000);
        const rate = this.arrivals.length > 1 ? 1000 * (this.arrivals.length - 1) / (now - this.arrivals[0]) : 0;
        const middle = this.latencies.toSorted((x, y) => x - y)[this.latencies.length >> 1];
        this.latency = middle;
        this.rate = rate;
        $("status").textContent = `${rate.toFixed(1)} frames/s` + (middle ? `, input to picture ${middle.toFixed(0)} ms` : "") +
            `, viewer ${header.view_milliseconds.toFixed(1)} ms per frame` +
            (header.reference_frames ? `, reference of ${header.reference_frames} frames` : "");
    }

    report(text, kind = "") {
        const line = Object.assign(document.createElement("div"), { className: kind });
        const close = Object.assign(document.createElement("button"), { textContent: "\u00d7", title: "close", ariaLabel: "close this message" });
        close.onclick = () => line.remove();
        line.append(text, close);
        $("messages").replaceChildren(...[...$("messages").children].slice(-2), line);
        if (kind)
            setTimeout(() => line.remove(), 4000);
    }

    bindControls() {
        $("play").onclick = () => this.send("play", { on: !this.state.playing });
        for (const name of ["step", "restart", "home"])
            $(name).onclick = () => this.send(name);
        $("view").onchange = event => this.sendView(event.target.value);
        $("exposure").oninput = event => this.send("exposure", { stops: Number(event.target.value) });
        $("keep").onchange = event => this.send("keep", { on: event.target.checked });
        $("fov").onchange = withNumber(degrees => this.send("fov", { yfov: degrees * Math.PI / 180 }));
        $("time").oninput = event => this.send("time", { seconds: Number(event.target.value) });
        $("speed").onchange = withNumber(factor => this.send("speed", { factor }));
        $("camera").onchange = event => this.send("camera", { number: Number(event.target.value) });
        $("copy").onchange = event => {
            const kind = event.target.value;
            event.target.value = "";
            if (kind === "command")
                this.copyCommand();
            else
                this.copy(this.state[kind]);
        };
        $("reference").onchange = event => this.send("reference", { source: event.target.value });
        $("length").onchange = withNumber(frames => { $("length").defaultValue = frames; });
        $("film").onclick = () => {
            if (!this.state.film && !$("length").reportValidity())
                return;
            if (this.controls.answered < this.filmAsked)  // whether there is a film is not known yet
                return;
            this.send("film", { frames: this.state.film ? 0 : Number($("length").value), kind: $("kind").value });
            this.filmAsked = this.controls.asked;
        };
        for (const side of ["a", "b"])
            $(side).onchange = event => {
                this.stage.set({ [side]: Number(event.target.value) });
                if (this.state.view === "difference")
                    this.sendView("difference");
            };
        for (const button of document.querySelectorAll("[data-mode]"))
            button.onclick = () => this.stage.set({ mode: button.dataset.mode });
    }

    // The view, with the graphs that a difference is of.
    sendView(name) {
        this.send("view", { name, left: this.stage.look.a, right: this.stage.look.b });
    }

    // The command line of the left picture as it is shown, if there is one.
    command() {
        const panes = this.header?.panes;
        return panes?.[Math.min(this.stage.look.a, panes.length - 1)].command;
    }

    copyCommand() {
        const command = this.command();
        if (command)
            this.copy(command);
        else
            this.report(this.header ? "With kept history there is no command line: the picture depends on earlier moves of the camera." : "No picture has come yet.");
    }

    async copy(text) {
        try {
            await navigator.clipboard.writeText(text);
            this.report(`copied: ${text}`, "note");
        } catch {
            this.report(text);  // where the browser gives no clipboard it can be selected
        }
    }

    // Where the animation is: the slider follows it, unless a hand is on it.
    showTime(time) {
        const slider = $("time"), held = this.state?.speed ? slider.matches(":active") : document.activeElement === slider;
        if (!held)
            slider.value = time;
        slider.nextElementSibling.textContent = `${time.toFixed(2)} s`;
    }

    showState() {
        const s = this.state, several = s.panes.length > 1;
        document.title = s.panes.map(pane => pane.name).join(" | ");
        $("play").textContent = s.playing ? "pause" : "play";
        for (const [side, chosen] of [["a", this.stage.look.a], ["b", this.stage.look.b]]) {
            $(side).hidden = s.panes.length < 3;
            $(side).replaceChildren(...s.panes.map((pane, i) => new Option(pane.name, i, false, i === chosen)));
        }
        for (const button of document.querySelectorAll("[data-mode]"))
            button.parentElement.hidden = !several;
        $("view").options[1].disabled = !several;
        $("view").options[2].disabled = s.reference === "none";
        $("reference").options[1].disabled = !s.has_file;
        $("camera").hidden = s.cameras.length < 2;
        if ($("camera").childElementCount !== s.cameras.length + 1)
            $("camera").replaceChildren(new Option("camera ...", ""), ...s.cameras.map((name, i) => new Option(name || `camera ${i}`, i)));
        $("camera").value = "";
        $("filming").hidden = !s.films;
        this.showFilm(s.film, s.filmed);
        const fill = (id, value) => this.controls.fill($(id), value);
        fill("reference", s.reference);
        fill("view", s.view);
        fill("exposure", s.exposure);
        $("exposure").nextElementSibling.textContent = s.exposure.toFixed(2);
        fill("keep", s.keep);
        fill("fov", (s.camera.yfov * 180 / Math.PI).toFixed(1));
        for (const label of document.querySelectorAll(".animation"))
            label.hidden = s.duration === 0;
        $("time").max = s.duration;
        this.showTime(s.time);
        fill("speed", s.speed);
        this.stage.set({});
        this.panel.showState(s);
    }
}

window.page = new Page();
