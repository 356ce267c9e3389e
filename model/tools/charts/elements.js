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

    /// What C++ has deflated and written as base64.
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

    /// Where the clipboard is closed, the text is marked, so that a key copies it. `place`: the element that shows it.
    function copyButton(text, place) {
        const copy = element("button", {type: "button", onclick: () => {
            const done = () => { copy.textContent = "Copied"; };
            navigator.clipboard.writeText(typeof text === "function" ? text() : text).then(done, () => {
                const range = document.createRange();
                range.selectNodeContents(place());
                getSelection().removeAllRanges();
                getSelection().addRange(range);
            });
        }}, "Copy");
        return copy;
    }

    const clockKinds = [["busy", "busy_cycles"], ["page misses", "page_miss_cycles"], ["refreshes", "refresh_cycles"],
                        ["link's writes", "write_cycles"],
                        ["table", "table_cycles"], ["arbiter", "grant_cycles"], ["polls", "poll_cycles"],
                        ["lost", "lost_cycles"], ["idle", "idle_cycles"]];
    const clockColours = ["#0072b2", "#d55e00", "#56b4e9", "#f0e442", "#cc79a7", "#009e73", "#e69f00", "#7a3b00",
                          "#9aa3ad"];

    /// What the report says of each bus, drawn: where its clocks went.
    function busesOf(report) {
        const renderers = Array.isArray(report.renderers) ? report.renderers.slice(0, 32) : [];
        if (!renderers.length || !renderers[0].bus) return [];
        const key = element("div", {class: "key"}, ...clockKinds.map(([name], n) =>
            element("span", {}, element("i", {style: "background:" + clockColours[n]}), name)));
        const rows = renderers.map(renderer => {
            const clocks = clockKinds.map(([, counter]) => Number(renderer.bus[counter]) || 0);
            const all = clocks.reduce((sum, count) => sum + count, 0) || 1;
            const words = clockKinds.map(([name], n) => `${name} ${percent(clocks[n] / all)}`).join(", ");
            return element("tr", {}, element("th", {scope: "row"}, String(renderer.name)), element("td", {},
                element("div", {class: "bar", role: "img", "aria-label": words, title: words}, ...clocks.map((count, n) =>
                    element("span", {style: `width:${100 * count / all}%;background:${clockColours[n]}`})))));
        });
        const more = report.renderers.length - renderers.length;
        return [element("h3", {}, "Where the clocks of each bus went"), key,
                element("table", {}, element("tbody", {}, ...rows)),
                more > 0 ? element("p", {class: "what"}, `and ${more} more`) : null];
    }

    return {element, percent, shellWord, inflated, inflatedText, saveButton, copyButton, clockKinds, clockColours, busesOf};
})();
