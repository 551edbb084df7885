// The panel: of each graph its times, knobs, ports and downloads; the inspected pixel.
"use strict";

import { withNumber } from "./controls.js";

function element(name, properties = {}, ...children) {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
}

const bytes = count => count < 1e6 ? `${(count / 1e3).toFixed(0)} kB` : `${(count / 1e6).toFixed(1)} MB`;
const STEP = 1 / 64;  // of log(frames), from one point of a chart's line to the next but one at least: no more than a pixel or two
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];

export class Panel {
    constructor(root, page) {
        this.root = root;
        this.page = page;
        this.errors = [];  // of each graph: [frames, MAPE]
        this.chart = element("canvas", { className: "chart", hidden: true, width: 316, height: 90, role: "img" });
        this.pixel = element("div", { className: "values" });
        this.sections = element("div");
        root.append(this.chart, this.pixel, this.sections);
    }

    // Built anew only when passes or declarations change: an input that is typed into stays.
    showState(state) {
        const structure = JSON.stringify(state.panes.map(pane => [pane.name, pane.ports, pane.passes.map(pass => [pass.name, pass.knobs.map(knob => ({ ...knob, value: 0 }))])]));
        if (structure !== this.structure) {
            this.structure = structure;
            this.panes = state.panes.map((pane, i) => this.buildPane(pane, i));
            this.sections.replaceChildren(...this.panes.map(pane => pane.section));
            this.errors = state.panes.map(() => []);
        }
        state.panes.forEach((pane, i) => this.fill(this.panes[i], pane));
    }

    buildPane(pane, index) {
        const section = element("section"), inputs = new Map();
        const port = element("select", { onchange: event => this.page.send("show", { pane: index, port: event.target.value || null }) },
                             new Option("picture", ""), ...pane.ports.map(name => new Option(name, name)));
        const times = element("table"), summary = element("div", { className: "actions" });
        const download = (name, text) => element("a", { href: `capture/${name}?pane=${index}`, textContent: text, download: "" });
        section.append(
            element("h2", { textContent: pane.name, title: pane.file, style: `color: ${COLOURS[index]}` }), summary, times,
            element("div", { className: "actions" }, element("label", {}, "show ", port)),
            element("div", { className: "actions" }, download("picture.png", "PNG"), download("outputs.exr", "EXR"), download("graph.json", "graph file"),
                    element("button", { textContent: "copy as --set", onclick: () => this.copyArguments(index) }),
                    element("button", { textContent: "reset knobs", onclick: () => this.page.send("reset", { pane: index }) })));
        for (const pass of pane.passes.filter(pass => pass.knobs.length))
            section.append(this.buildPass(pass, index, inputs));
        return { section, inputs, port, times, summary };
    }

    copyArguments(index) {
        const words = this.page.state.panes[index].arguments;
        if (words)
            this.page.copy(words);
        else
            this.page.report("no knob has been turned: there is nothing to copy", "note");
    }

    buildPass(pass, index, inputs) {
        const box = element("details", { open: true }, element("summary", { textContent: pass.name, title: `${pass.type}: ${pass.meaning}` }));
        for (const knob of pass.knobs) {
            const path = `${pass.name}.${knob.name}`;
            const input = this.buildInput(knob, value => this.page.send("set", { pane: index, knob: path, value }));
            const range = knob.minimum === undefined ? "" : ` (${knob.minimum} .. ${knob.maximum})`;
            const line = element("label", { className: "knob", title: `${knob.meaning}${range}${knob.structural ? "; a change rebuilds the pass" : ""}` },
                                 element("span", {}, knob.name, " ", element("em", { textContent: knob.structural ? "rebuilds" : "" })), input);
            box.append(line);
            inputs.set(path, { input, line, knob });
        }
        return box;
    }

    buildInput(knob, send) {
        if (knob.type === "bool")
            return element("input", { type: "checkbox", onchange: event => send(event.target.checked) });
        if (knob.type === "choice")
            return element("select", { onchange: event => send(event.target.value) }, ...knob.choices.map(choice => new Option(choice, choice)));
        if (knob.type === "string")
            return element("input", { type: "text", onchange: event => send(event.target.value) });
        const step = knob.type === "float" ? "any" : 1;
        return element("input", { type: "number", step, onchange: withNumber(send) });
    }

    fill(built, pane) {
        for (const pass of pane.passes)
            for (const knob of pass.knobs) {
                const { input, line } = built.inputs.get(`${pass.name}.${knob.name}`);
                line.classList.toggle("changed", knob.value !== knob.initial);
                const value = knob.type === "float" ? Number(Number(knob.value).toPrecision(7)) : knob.value;
                this.page.controls.fill(input, value);
            }
        this.page.controls.fill(built.port, pane.port ?? "");
    }

    showFrame(header) {
        if (header.reference !== this.reference) {  // whose errors are others
            this.reference = header.reference;
            this.errors.forEach(line => { line.length = 0; });
        }
        header.panes.forEach((pane, i) => this.showTimes(this.panes?.[i], pane, header.reference !== "none"));
        this.addErrors(header.panes);
    }

    showTimes(built, pane, measured) {
        if (!built)
            return;
        const mape = pane.mape !== null ? `, MAPE ${(100 * pane.mape).toFixed(2)}%` : measured ? `, no error: ${pane.no_error}` : "";
        built.summary.textContent = `${pane.frames} frames, ${pane.milliseconds.toFixed(1)} ms each, ${bytes(pane.memory)}${mape}`;
        const most = Math.max(...Object.values(pane.passes), 1e-9);
        built.times.replaceChildren(...Object.entries(pane.passes).map(([name, time]) => element("tr", {},
            element("td", { textContent: name }), element("td", { style: "width: 50%" }, element("div", { className: "share", style: `width: ${100 * time / most}%` })),
            element("td", { textContent: `${time.toFixed(2)} ms` }))));
    }

    addErrors(panes) {
        panes.forEach((pane, i) => {
            const line = this.errors[i] ??= [];
            if (pane.mape === null || line.length && pane.frames < line.at(-1)[0])
                line.length = 0;
            if (Number.isFinite(pane.mape) && pane.mape > 0 && pane.frames !== line.at(-1)?.[0])
                this.addPoint(line, [pane.frames, pane.mape]);
        });
        this.chart.hidden = !this.errors.some(line => line.length);
        if (!this.chart.hidden)
            this.drawErrors();
    }

    // The last point gives way where it is close behind the one before it: some hundreds are left of any number of frames.
    addPoint(line, point) {
        if (line.length > 1 && Math.log(point[0] / line.at(-2)[0]) < STEP)
            line.pop();
        line.push(point);
    }

    // MAPE over frames, both logarithmic.
    drawErrors() {
        const context = this.chart.getContext("2d"), { width, height } = this.chart, all = this.errors.flat();
        const least = all.reduce((least, [, error]) => Math.min(least, error), Infinity);
        const most = all.reduce((most, [, error]) => Math.max(most, error), 0);
        const low = Math.log(least), high = Math.log(most), last = Math.log(all.reduce((most, [frames]) => Math.max(most, frames), 2));
        context.clearRect(0, 0, width, height);
        this.errors.forEach((line, i) => {
            context.strokeStyle = COLOURS[i];
            context.beginPath();
            for (const [frames, error] of line)
                context.lineTo(4 + (width - 8) * Math.log(frames) / last, 14 + (height - 20) * (high - Math.log(error)) / Math.max(high - low, 1e-3));
            context.stroke();
        });
        context.fillStyle = "#5b6675";
        const ranges = `MAPE ${(100 * Math.exp(low)).toFixed(2)} to ${(100 * Math.exp(high)).toFixed(2)}%, 1 to ${Math.round(Math.exp(last))} frames`;
        context.fillText(ranges, 4, 10);
        const now = this.errors.map((line, i) => line.length ? `; ${this.page.state.panes[i].name}: ${(100 * line.at(-1)[1]).toFixed(2)}%` : "");
        this.chart.ariaLabel = `${ranges}${now.join("")}`;
    }

    showPixel(pixel) {
        const text = value => (Array.isArray(value) ? value : [value]).map(part => Number(part).toPrecision(4)).join(" ");
        const rows = values => Object.entries(values).map(([name, value]) => element("tr", {}, element("td", { textContent: name }), element("td", { textContent: text(value) })));
        const ask = (pane, product) => () => this.page.send("guide", { pane, x: pixel.x, y: pixel.y, product });
        this.guide = element("div");
        this.told = pixel;
        const geometry = pixel.geometry ? element("table", {}, ...rows(pixel.geometry)) : element("div", { textContent: "it shows no surface" });
        this.pixel.replaceChildren(element("h2", { textContent: `pixel ${pixel.x}, ${pixel.y}` }), element("div", { className: "earlier", textContent: "of an earlier view" }), geometry,
            ...pixel.panes.flatMap((values, i) => [
                element("div", { textContent: this.page.state.panes[i].name, style: `color: ${COLOURS[i]}` }), element("table", {}, ...rows(values)),
                ...Object.entries(pixel.reservoirs[i]).map(([port, lines]) => element("div", { className: "reservoir" }, element("b", { textContent: port }),
                    ...lines.map(([what, meaning]) => element("div", {}, `${what} `, element("em", { textContent: meaning }))))),
                ...this.page.state.panes[i].guided ? [element("div", { className: "actions" }, element("button", { textContent: "guide here", onclick: ask(i, false) }),
                    element("button", { textContent: "with the true product", title: "path traced from the point: some seconds", onclick: ask(i, true) }))] : []]),
            this.guide);
        this.markPixel(this.page.view);
    }

    // What was told of a pixel is of an earlier view once there is another: its guide is not asked for any more.
    markPixel(view) {
        const earlier = this.told !== undefined && this.told.view_number !== view;
        this.pixel.classList.toggle("passed", earlier);
        this.pixel.querySelectorAll("button").forEach(button => { button.disabled = earlier; });
    }

    // The hemisphere about the normal: azimuth to the right, cosine downwards from 1 to 0.
    showGuide(guide) {
        if (["x", "y", "view_number"].some(name => guide[name] !== this.told?.[name])) {
            this.page.report(`The view has changed since the guide at pixel ${guide.x}, ${guide.y} was asked for: click the pixel again.`, "note");
            return;
        }
        const lobes = (guide.lobes ?? []).map(pair => pair.map(Number)).map(([kappa, weight]) => element("tr", {}, element("td", { textContent: `lobe, kappa ${kappa.toPrecision(3)}` }),
                                                                             element("td", { textContent: `${(100 * weight).toFixed(1)}%` })));
        const told = guide.lobes ? `, alpha ${Number(guide.alpha).toFixed(3)}, learnt from ${Number(guide.samples).toFixed(0)} samples, last ${guide.age} frames ago` : ": nothing learnt yet";
        this.guide.replaceChildren(element("h2", { textContent: `guide of ${this.page.state.panes[guide.pane].name}`, style: `color: ${COLOURS[guide.pane]}` }),
            element("div", { textContent: `cell of ${(100 * guide.side).toPrecision(3)} cm${told}` }), element("table", {}, ...lobes),
            ...Object.entries(guide.maps).map(([name, data]) => element("figure", {}, element("figcaption", { textContent: name }),
                element("img", { src: `data:image/png;base64,${data}` }))));
    }
}
