// What the pages have in common. Everything from results is data: it reaches the document as text, never as markup.
const metabufferElements = (() => {
    "use strict";

    /// An element with text or other elements inside.
    function element(name, attributes, ...content) {
        const made = document.createElement(name);
        for (const [key, value] of Object.entries(attributes || {})) {
            if (value === undefined || value === null || value === false) continue;
            if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
            else if (key === "class") made.className = value;
            else made.setAttribute(key, value === true ? "" : value);
        }
        made.append(...content.filter(part => part !== null && part !== undefined));
        return made;
    }

    const percent = share => `${(100 * share).toFixed(1)}%`;
    const shellWord = word => /^[\w.,:\/=+@%-]+$/.test(word) ? word : "'" + word.replace(/'/g, "'\\''") + "'";

    /// Inflates what C++ has deflated and written as base64.
    async function inflated(text) {
        const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
        const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
        return new Response(stream).arrayBuffer();
    }
    const inflatedText = async text => new TextDecoder().decode(await inflated(text));

    function saveButton(title, file, text) {
        return element("button", {type: "button", onclick: () => {
            const link = element("a", {href: "data:application/json;charset=utf-8," + encodeURIComponent(text), download: file});
            link.click();
        }}, title);
    }

    /// If the page may not write to the clipboard, it selects the text, so that the user can copy it with a key.
    /// `target` returns the element that shows the text.
    function copyButton(text, target) {
        const copy = element("button", {type: "button", onclick: () => {
            const done = () => { copy.textContent = "Copied"; };
            navigator.clipboard.writeText(typeof text === "function" ? text() : text).then(done, () => {
                const range = document.createRange();
                range.selectNodeContents(target());
                getSelection().removeAllRanges();
                getSelection().addRange(range);
            });
        }}, "Copy");
        return copy;
    }

    /// Gives a view's canvas a size in CSS pixels, at the screen's resolution. Returns false if it has that size
    /// already.
    function sizeCanvas(view, width, height) {
        const ratio = window.devicePixelRatio || 1;
        if (view.width === width && view.height === height && view.ratio === ratio) return false;
        Object.assign(view, {width, height, ratio});
        view.canvas.width = Math.round(width * ratio);
        view.canvas.height = Math.round(height * ratio);
        view.canvas.style.width = width + "px";
        view.canvas.style.height = height + "px";
        return true;
    }

    /// What a bus does in a clock, with the report's counter, in the order of the bars. Text on a light colour is dark.
    const clockKinds = [{counter: "busy_cycles", name: "pixels", colour: "#0072b2"},
                        {counter: "page_miss_cycles", name: "page miss", colour: "#d55e00"},
                        {counter: "refresh_cycles", name: "refresh", colour: "#56b4e9", isLight: true},
                        {counter: "write_cycles", name: "link writes", colour: "#f0e442", isLight: true},
                        {counter: "table_cycles", name: "table", colour: "#cc79a7"},
                        {counter: "grant_cycles", name: "arbitration", colour: "#009e73"},
                        {counter: "poll_cycles", name: "poll", colour: "#e69f00"},
                        {counter: "lost_cycles", name: "lost slot", colour: "#7a3b00"},
                        {counter: "idle_cycles", name: "idle", colour: "#9aa3ad"}];

    /// Draws, from the report, what each bus did in its clocks.
    function busesOf(report) {
        const renderers = Array.isArray(report.renderers) ? report.renderers.slice(0, 32) : [];
        if (!renderers.length || !renderers[0].bus) return [];
        const key = element("div", {class: "key"}, ...clockKinds.map(({name, colour}) =>
            element("span", {}, element("i", {style: "background:" + colour}), name)));
        const rows = renderers.map(renderer => {
            const clocks = clockKinds.map(({counter}) => Number(renderer.bus[counter]) || 0);
            const all = clocks.reduce((sum, count) => sum + count, 0) || 1;
            const words = clockKinds.map(({name}, n) => `${name} ${percent(clocks[n] / all)}`).join(", ");
            return element("tr", {}, element("th", {scope: "row"}, String(renderer.name)), element("td", {},
                element("div", {class: "bar", role: "img", "aria-label": words, title: words}, ...clocks.map((count, n) =>
                    element("span", {style: `width:${100 * count / all}%;background:${clockKinds[n].colour}`})))));
        });
        const more = report.renderers.length - renderers.length;
        return [element("h3", {}, "Where the clocks of each bus went"), key,
                element("table", {}, element("tbody", {}, ...rows)),
                more > 0 ? element("p", {class: "what"}, `and ${more} more`) : null];
    }

    return {element, percent, shellWord, inflated, inflatedText, saveButton, copyButton, sizeCanvas, clockKinds, busesOf};
})();
