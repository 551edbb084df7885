// Mouse and keys on the stage, as commands for the camera. Moves between two animation frames are sent as one.
"use strict";

const ARROWS = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, 1], arrowdown: [0, -1] };
const ARROW = 0.05;  // radians
const KEYS = { w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], q: [0, -1, 0], e: [0, 1, 0] };
const TURN = 4;  // radians over a picture's height
const SPEED = 0.8;  // of the target's distance, a second

export class Navigation {
    constructor(page) {
        this.page = page;
        this.pending = new Map();  // command: what it has come to since the last animation frame
        this.held = new Set();
        document.addEventListener("keydown", event => this.key(event));
        document.addEventListener("keyup", event => this.held.delete(event.key.toLowerCase()));
        window.addEventListener("blur", () => this.held.clear());
        this.last = performance.now();
    }

    attach(canvas) {
        canvas.addEventListener("pointerdown", event => this.drag(canvas, event));
        canvas.addEventListener("wheel", event => this.wheel(canvas, event), { passive: false });
        canvas.addEventListener("dblclick", event => this.page.send("focus", this.pixel(canvas, event)));
        canvas.addEventListener("contextmenu", event => event.preventDefault());
    }

    // Where on the canvas an event is, as fractions.
    place(canvas, event) {
        const box = canvas.getBoundingClientRect();
        return { u: (event.clientX - box.left) / box.width, v: (event.clientY - box.top) / box.height, box };
    }

    pixel(canvas, event) {
        const { u, v } = this.place(canvas, event), { zoom, x, y } = this.page.stage.look, [width, height] = this.page.state.size;
        const inside = (value, size) => Math.min(size - 1, Math.max(0, Math.floor(value * size)));
        return { x: inside(x + u / zoom, width), y: inside(y + v / zoom, height) };
    }

    // The pixel that was inspected last, or the middle one.
    lastPixel() {
        const [width, height] = this.page.state.size;
        return this.inspected ?? { x: width >> 1, y: height >> 1 };
    }

    inspect(pixel) {
        this.inspected = pixel;
        this.page.send("inspect", pixel);
    }

    // Whether the key is one of a canvas that has the focus.
    keyOfCanvas(key) {
        if (key === "enter")
            this.inspect(this.lastPixel());
        else if (key in ARROWS)
            this.add("orbit", { x: ARROW * ARROWS[key][0], y: ARROW * ARROWS[key][1] });
        else
            return false;
        return true;
    }

    // Add to a command's arguments, and send them at the next animation frame.
    add(name, change) {
        const sum = this.pending.get(name) ?? {};
        for (const [key, value] of Object.entries(change))
            sum[key] = (sum[key] ?? 0) + value;
        this.pending.set(name, sum);
        this.schedule();
    }

    schedule() {
        this.scheduled ??= requestAnimationFrame(now => this.flush(now));
    }

    flush(now) {
        this.scheduled = undefined;
        const seconds = Math.min(0.1, (now - this.last) / 1000);
        this.last = now;
        const move = [0, 0, 0];
        for (const key of this.held)
            KEYS[key].forEach((part, i) => { move[i] += part * SPEED * seconds * (this.fast ? 4 : 1); });
        if (move.some(part => part !== 0))
            this.page.send("fly", { x: move[0], y: move[1], z: move[2] });
        for (const [name, change] of this.pending)
            this.page.send(name, change);
        this.pending.clear();
        if (this.held.size)
            this.schedule();
    }

    key(event) {
        if (event.target.matches("input:not([type=range]):not([type=checkbox]), select, textarea") || event.ctrlKey || event.metaKey || event.altKey)
            return;
        if (event.key === " " && event.target.matches("button, summary, input, a, select, textarea"))
            return;  // it presses what has the focus
        const key = event.key.toLowerCase(), page = this.page, stage = page.stage;
        if (event.target.matches("#stage canvas") && this.keyOfCanvas(key)) {
            event.preventDefault();
            return;
        }
        this.fast = event.shiftKey;
        if (key in KEYS) {
            if (!this.held.size)
                this.last = performance.now();
            this.held.add(key);
            this.schedule();
            return;
        }
        const action = { " ": () => page.send("play", { on: !page.state.playing }), ".": () => page.send("step"), r: () => page.send("restart"),
                         h: () => page.send("home"), b: () => stage.set({ mode: stage.look.mode === "blink" ? "split" : "blink" }) }[key];
        if (action) {
            event.preventDefault();
            action();
        }
    }

    drag(canvas, event) {
        const stage = this.page.stage, start = this.place(canvas, event);
        const splits = stage.splits() && event.button === 0 && Math.abs(start.u - stage.look.split) < 10 / start.box.width;
        const kind = event.button === 2 || event.shiftKey ? "pan" : event.button === 1 || event.altKey ? "look" : "orbit";
        let last = event, moved = false;
        event.preventDefault();
        canvas.focus({ preventScroll: true });
        canvas.setPointerCapture(event.pointerId);
        const move = now => {
            const x = (now.clientX - last.clientX) / start.box.height, y = (now.clientY - last.clientY) / start.box.height;
            moved ||= Math.hypot(now.clientX - event.clientX, now.clientY - event.clientY) > 3;
            if (!moved)
                return;
            last = now;
            if (splits)
                stage.set({ split: Math.min(1, Math.max(0, this.place(canvas, now).u)) });
            else if (kind === "orbit")
                this.add("orbit", { x: -TURN * x, y: TURN * y });
            else if (kind === "look")
                this.add("look", { x: -TURN / 2 * x, y: -TURN / 2 * y });
            else
                this.add("pan", { x: -x / stage.look.zoom, y: y / stage.look.zoom });
        };
        canvas.addEventListener("pointermove", move);
        const end = now => {
            canvas.removeEventListener("pointermove", move);
            if (!moved && !splits && kind === "orbit" && now.type === "pointerup")
                this.inspect(this.pixel(canvas, now));
        };
        canvas.addEventListener("pointerup", end, { once: true });
        canvas.addEventListener("pointercancel", end, { once: true });
    }

    wheel(canvas, event) {
        event.preventDefault();
        const amount = -event.deltaY / 600;
        if (!event.ctrlKey) {
            this.add("dolly", { amount });
            return;
        }
        const look = this.page.stage.look, { u, v } = this.place(canvas, event);
        const zoom = Math.min(64, Math.max(1, look.zoom * 2 ** (2 * amount)));
        this.page.stage.set({ zoom, x: look.x + u / look.zoom - u / zoom, y: look.y + v / look.zoom - v / zoom });
    }
}
