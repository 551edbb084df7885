// Controls show the state, except one that a hand is at, and one whose command the server has not answered yet.
"use strict";

// An event's handler that gives `send` the number of the control. What is no number, as an emptied field, goes back to what was there.
export const withNumber = send => ({ target }) => target.value === "" ? target.value = target.defaultValue : send(Number(target.value));

export class Controls {
    // refill: fill all controls from the state.
    constructor(refill) {
        this.refill = refill;
        this.asked = this.answered = 0;  // ids of the last command, and of the last one that the server has done or refused
        document.addEventListener("input", event => { this.edited = event.target; }, true);
        document.addEventListener("change", event => Object.assign(this, { edited: undefined, changed: event.target }), true);
        document.addEventListener("focusout", () => {
            this.edited = undefined;
            queueMicrotask(refill);
        }, true);
    }

    fill(control, value) {
        control.defaultValue = value;
        if (control === this.edited || control === this.changed && this.answered < this.asked)
            return;
        if (control.type === "checkbox")
            control.checked = value;
        else
            control.value = value;
    }

    // The server has done or refused the command, and all before it.
    answer(id) {
        this.answered = Math.max(this.answered, id);
    }
}
