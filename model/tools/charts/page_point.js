// What the report page shows of one point or simulation: its report, its pictures, and the command that runs it by hand.
const metabufferPoint = (() => {
    "use strict";
    const {formatValue, isNumber, isThere} = metabufferScales;
    const {element, shellWord, inflatedText, busesOf, saveButton, copyButton} = metabufferElements;
    const {data} = metabufferResults;

    /// A value as --set reads it. A text that YAML might not read as a text is quoted; lists and maps are not.
    function yamlValue(value) {
        if (isNumber(value)) return String(value);
        const isCollection = /^[[{]/.test(value);
        const isPlain = /^[A-Za-z_./][\w./+ -]*$/.test(value) && !/ $/.test(value);
        return isCollection || isPlain ? value : "'" + value.replace(/'/g, "''") + "'";
    }

    /// Joins the path of a folder and the path of a file in it, which is relative to the folder or absolute.
    function joinedPath(folder, file) {
        if (!folder || file.startsWith("/")) return file;
        const parts = [];
        for (const part of `${folder}/${file}`.split("/")) {
            const isUp = part === ".." && parts.length && parts[parts.length - 1] !== ".." && parts[parts.length - 1];
            if (isUp) parts.pop();
            else if (part !== "." && (part || !parts.length)) parts.push(part);
        }
        return parts.join("/");
    }

    /// The command that runs a point by hand, with pictures.
    function commandOf(item) {
        const source = data.sources[item.source];
        let scenario = source.scenario || "SCENARIO";
        const settings = [...(source.fixed || [])];
        data.axes.forEach((key, n) => {
            if (!isThere(item.axes[n])) return;
            if (key === "scenario") scenario = joinedPath(source.base, String(item.axes[n]));
            else settings.push([key, item.axes[n]]);
        });
        const found = item.isPoint ? item.smallest : item.looked;
        if (source.search_key && isThere(found)) settings.push([source.search_key, found]);
        return ["metabuffer run " + shellWord(scenario),
                ...(source.level === "tlm" ? [] : [`    --level ${source.level}`]),
                ...settings.map(([key, value]) => "    --set " + shellWord(`${key}=${yamlValue(value)}`)),
                `    --out out/${item.isPoint ? "point" : "simulation"}-${item.id}`].join(" \\\n");
    }

    function pairs(rows) {
        return element("table", {}, element("tbody", {}, ...rows.map(([name, value, meaning]) =>
            element("tr", {title: meaning || null}, element("th", {scope: "row"}, name),
                    element("td", {class: "number"}, formatValue(value))))));
    }

    function reportPart(item) {
        const embedded = data.embedded[`${item.source}:${item.run}`];
        const box = element("div", {id: "panel-report"});
        if (!embedded || !embedded.report) {
            const why = !isThere(item.run) || (item.status !== "done" && item.status !== "watchdog" && !embedded)
                ? "There is no report: no run of this point came to its end."
                : "The report is not in this page. " + (item.isPoint ? `The page holds ${data.left_out.mebibytes} MiB of reports ` +
                    "and pictures at most; one of fewer points (--where), or with a larger --embed-mib, has it; so has " +
                    "the run by hand." : "The run by hand writes it.");
            box.append(element("p", {class: "what"}, why));
            return box;
        }
        box.append(element("p", {class: "what"}, "…"));
        inflatedText(embedded.report).then(text => {
            const pre = element("pre", {class: "report", tabindex: "0"});
            const details = element("details", {}, element("summary", {}, "report.json, in full"), pre);
            // The text is laid out only when the user asks for it: it may have megabytes.
            details.addEventListener("toggle", () => { if (details.open && !pre.firstChild) pre.textContent = text; });
            const save = saveButton("Save report.json", "report.json", text);
            let buses = [];
            try {
                buses = busesOf(JSON.parse(text));
            } catch (error) {
                buses = [element("p", {class: "what"}, "The report is no JSON.")];
            }
            box.replaceChildren(...buses.filter(part => part !== null), element("h3", {}, "Report"), details,
                                element("p", {}, save));
        }, () => box.replaceChildren(element("p", {class: "what"}, "This browser cannot unpack the report; a newer one can.")));
        return box;
    }

    function picturesPart(item) {
        const embedded = data.embedded[`${item.source}:${item.run}`];
        const pictures = embedded && embedded.pictures || [];
        if (!pictures.length) return [];
        return [element("h3", {}, "Pictures"), element("div", {class: "pictures"}, ...pictures.map(([display, png]) =>
            element("figure", {}, element("img", {src: "data:image/png;base64," + png, alt: `What display ${display} shows last`}),
                    element("figcaption", {}, `display ${display}`))))];
    }

    function commandPart(item) {
        const command = commandOf(item);
        const needsScenario = !data.sources[item.source].scenario && !data.axes.includes("scenario");
        const copy = copyButton(command, () => document.getElementById("command"));
        return [element("h3", {}, "Run by hand, with pictures"), element("pre", {id: "command"}, command),
                needsScenario ? element("p", {class: "what"}, "SCENARIO: the scenario that the sweep was made from.") : null,
                element("p", {}, copy)];
    }

    return {pairs, reportPart, picturesPart, commandPart};
})();
