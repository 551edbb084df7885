// The picture viewer of a report. A scene's data: { width, height, floor (0.01 mean luminance of the reference), exposure
// (stops), scale (of the error map), pictures: [{ label, image, mean?, frame? }] }, the reference first; image, mean and frame
// are base64 of half floats, row by row, RGB.
"use strict";

const HALF = new Float32Array(65536);
for (let bits = 0; bits < 65536; ++bits) {
    const sign = bits & 0x8000 ? -1 : 1, exponent = (bits >> 10) & 31, fraction = bits & 1023;
    HALF[bits] = sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -14 * (fraction / 1024));
}

// The sRGB transfer function, tabulated over [0, 1].
const SRGB = new Uint8ClampedArray(4097).map((_, i) => {
    const linear = i / 4096;
    return Math.round(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));
});

function decode(text) {
    const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
    return Float32Array.from(new Uint16Array(bytes.buffer), half => HALF[half]);
}

class Viewer {
    constructor(root) {
        this.root = root;
        this.data = JSON.parse(root.querySelector("script").textContent);
        this.pictures = this.data.pictures;
        this.decoded = new Map();
        this.state = { mode: "split", a: Math.min(1, this.pictures.length - 1), b: this.pictures.length - 1, view: root.querySelector(".view option[value=frame]") ? "frame" : "image", exposure: this.data.exposure, scale: 0, split: 0.5, shown: "a" };
        root.style.setProperty("--aspect", this.data.width / this.data.height);
        this.resetView();
        this.buildControls();
        this.setMode("split");
        new ResizeObserver(() => this.draw()).observe(root.querySelector(".panes"));
    }

    find(selector) { return this.root.querySelector(selector); }

    resetView() { Object.assign(this.state, { zoom: 1, x: 0, y: 0 }); }  // x, y: the picture's point at the top left, 0..1

    buildControls() {
        const options = this.pictures.map((picture, i) => new Option(picture.label, i));
        for (const side of ["a", "b"]) {
            const select = this.find("select." + side);
            select.append(...options.map(option => option.cloneNode(true)));
            select.value = this.state[side];
            select.onchange = () => this.set({ [side]: Number(select.value) });
        }
        this.find(".view").value = this.state.view;
        this.find(".view").onchange = event => this.set({ view: event.target.value });
        for (const name of ["exposure", "scale"]) {
            const input = this.find(`.${name} input`);
            input.value = this.state[name];
            input.oninput = () => this.set({ [name]: Number(input.value) });
        }
        for (const button of this.root.querySelectorAll("[data-mode]"))
            button.onclick = () => this.setMode(button.dataset.mode);
        this.find(".reset").onclick = () => { this.resetView(); this.draw(); };
    }

    set(change) {
        Object.assign(this.state, change);
        this.draw();
    }

    setMode(mode) {
        this.state.mode = mode;
        for (const button of this.root.querySelectorAll("[data-mode]"))
            button.classList.toggle("on", button.dataset.mode === mode);
        clearInterval(this.timer);
        if (mode === "blink")
            this.timer = setInterval(() => this.set({ shown: this.state.shown === "a" ? "b" : "a" }), 600);
        const box = this.find(".panes");
        box.classList.toggle("tiles", mode === "tiles");
        box.replaceChildren();
        this.panes = (mode === "tiles" ? this.pictures : [null]).map((_, i) => this.buildPane(box, i));
        this.draw();
    }

    buildPane(box, number) {
        const element = document.createElement("div");
        element.className = "pane";
        element.innerHTML = '<canvas></canvas><span class="left"></span><span class="right"></span>';
        box.append(element);
        const canvas = element.querySelector("canvas");
        canvas.addEventListener("wheel", event => this.zoom(canvas, event), { passive: false });
        canvas.addEventListener("pointerdown", event => this.drag(canvas, event));
        canvas.addEventListener("pointermove", event => this.readPixel(canvas, event));
        return { number, canvas, left: element.querySelector(".left"), right: element.querySelector(".right") };
    }

    zoom(canvas, event) {
        event.preventDefault();
        const s = this.state, box = canvas.getBoundingClientRect();
        const u = (event.clientX - box.left) / box.width, v = (event.clientY - box.top) / box.height;
        const zoom = Math.min(64, Math.max(1, s.zoom * 2 ** (-event.deltaY / 300)));
        this.set({ zoom, x: s.x + u / s.zoom - u / zoom, y: s.y + v / s.zoom - v / zoom });
    }

    drag(canvas, event) {
        const s = this.state, box = canvas.getBoundingClientRect(), start = { x: s.x, y: s.y };
        const splits = s.mode === "split" && Math.abs((event.clientX - box.left) / box.width - s.split) < 12 / box.width;
        canvas.setPointerCapture(event.pointerId);
        const move = now => {
            if (splits)
                this.set({ split: Math.min(1, Math.max(0, (now.clientX - box.left) / box.width)) });
            else
                this.set({ x: start.x - (now.clientX - event.clientX) / box.width / s.zoom,
                           y: start.y - (now.clientY - event.clientY) / box.height / s.zoom });
        };
        canvas.addEventListener("pointermove", move);
        canvas.addEventListener("pointerup", () => canvas.removeEventListener("pointermove", move), { once: true });
    }

    // The linear pixels of a picture, of the kind now shown; the reference and left-out kinds fall back to the image.
    pixels(index, kind) {
        const picture = this.pictures[index], name = picture[kind] ? kind : "image";
        const key = index + name;
        if (!this.decoded.has(key))
            this.decoded.set(key, decode(picture[name]));
        return this.decoded.get(key);
    }

    // A canvas of the picture's own size, as shown with the present exposure, view and scale.
    rendered(index) {
        const { width, height } = this.data, { view, exposure, scale } = this.state;
        const key = [view, exposure, scale].join();
        if (key !== this.renderedKey)
            [this.renderedKey, this.renderedCanvases] = [key, new Map()];
        if (this.renderedCanvases.has(index))
            return this.renderedCanvases.get(index);
        const canvas = Object.assign(document.createElement("canvas"), { width, height });
        const context = canvas.getContext("2d"), out = context.createImageData(width, height);
        if (view === "error" || view === "signed")
            this.paintError(index, out.data);
        else
            this.paintImage(this.pixels(index, view), 4096 * 2 ** exposure, out.data);
        context.putImageData(out, 0, 0);
        this.renderedCanvases.set(index, canvas);
        return canvas;
    }

    paintImage(pixels, gain, out) {
        for (let i = 0, o = 0; i < pixels.length; i += 3, o += 4) {
            for (let c = 0; c < 3; ++c)
                out[o + c] = SRGB[Math.min(4096, Math.max(0, Math.round(pixels[i + c] * gain)))];
            out[o + 3] = 255;
        }
    }

    // The error scale is one for all pictures of the scene: errorLimit() is the end of the colour map.
    errorLimit() { return this.data.scale * 2 ** this.state.scale; }

    paintError(index, out) {
        const signed = this.state.view === "signed", map = COLOUR_MAPS[signed ? "signed" : "error"], last = map.length / 3 - 1;
        const own = this.pixels(index, signed ? "mean" : "image"), truth = this.pixels(0, "image"), limit = this.errorLimit();
        for (let i = 0, o = 0; i < own.length; i += 3, o += 4) {
            let error = 0;
            for (let c = 0; c < 3; ++c)
                error += signed ? own[i + c] - truth[i + c] : Math.abs(own[i + c] - truth[i + c]);
            const y = 0.2126 * truth[i] + 0.7152 * truth[i + 1] + 0.0722 * truth[i + 2];
            error /= 3 * (this.data.floor + y) * limit;
            const entry = 3 * Math.round(last * Math.min(1, Math.max(0, signed ? 0.5 + 0.5 * error : error)));
            for (let c = 0; c < 3; ++c)
                out[o + c] = map[entry + c];
            out[o + 3] = 255;
        }
    }

    draw() {
        const s = this.state;
        for (const side of ["x", "y"])
            s[side] = Math.min(1 - 1 / s.zoom, Math.max(0, s[side]));
        for (const pane of this.panes) {
            const width = Math.round(pane.canvas.parentElement.clientWidth * devicePixelRatio);
            const height = Math.round(width * this.data.height / this.data.width);
            if (pane.canvas.width !== width || pane.canvas.height !== height)
                Object.assign(pane.canvas, { width, height });
            const context = pane.canvas.getContext("2d");
            const [left, right] = { split: [s.a, s.b], blink: [s[s.shown]], tiles: [pane.number] }[s.mode];
            this.blit(context, left, 0, right === undefined ? 1 : s.split);
            pane.left.textContent = this.pictures[left].label;
            pane.right.textContent = right === undefined ? "" : this.pictures[right].label;
            if (right !== undefined) {
                this.blit(context, right, s.split, 1);
                context.fillStyle = "#fff";
                context.fillRect(s.split * width - 1, 0, 2, height);
            }
        }
        this.find(".exposure output").textContent = s.exposure.toFixed(1);
        this.find(".scale output").textContent = "×" + (2 ** s.scale).toPrecision(2);
        this.drawLegend();
    }

    // Draw the part of a picture between two fractions of the pane's width.
    blit(context, index, from, to) {
        if (to <= from)
            return;
        const { zoom, x, y } = this.state, { width, height } = this.data, pane = context.canvas;
        context.imageSmoothingEnabled = pane.width < width / zoom;
        context.drawImage(this.rendered(index), (x + from / zoom) * width, y * height, (to - from) / zoom * width, height / zoom,
                          from * pane.width, 0, (to - from) * pane.width, pane.height);
    }

    drawLegend() {
        const { view } = this.state, error = view === "error" || view === "signed", canvas = this.find(".legend");
        canvas.style.display = error ? "" : "none";
        this.find(".legend-text").textContent = "";
        if (!error)
            return;
        const map = COLOUR_MAPS[view], limit = (100 * this.errorLimit()).toPrecision(3) + "%";
        const context = canvas.getContext("2d");
        for (let i = 0; i < 256; ++i) {
            const entry = 3 * Math.round(i / 255 * (map.length / 3 - 1));
            context.fillStyle = `rgb(${map.slice(entry, entry + 3)})`;
            context.fillRect(i, 0, 1, 12);
        }
        this.find(".legend-text").textContent = view === "signed" ? `−${limit} … ${limit}` : `0 … ${limit}`;
    }

    readPixel(canvas, event) {
        const box = canvas.getBoundingClientRect(), { zoom, x, y, view, a, b } = this.state, { width, height } = this.data;
        const column = Math.floor((x + (event.clientX - box.left) / box.width / zoom) * width);
        const row = Math.floor((y + (event.clientY - box.top) / box.height / zoom) * height);
        if (column < 0 || row < 0 || column >= width || row >= height)
            return;
        const kind = view === "error" ? "image" : view === "signed" ? "mean" : view;
        const text = index => Array.from(this.pixels(index, kind).subarray(3 * (row * width + column)).slice(0, 3))
            .map(value => value.toPrecision(4)).join(" ");
        this.find(".pixel").textContent = `${column}, ${row}   A ${text(a)}   B ${text(b)}`;
    }
}

const viewers = Array.from(document.querySelectorAll(".viewer"), root => new Viewer(root));
