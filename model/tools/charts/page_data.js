// The results that the report page is about: its points and simulations, and the fields that these have.
const metabufferResults = (() => {
    "use strict";
    const {inOrder, formatValue, isNumber, isThere} = metabufferScales;
    const data = JSON.parse(document.getElementById("data").textContent);

    const severalSources = data.sources.length > 1;
    const sourceNames = data.sources.map((source, n) => {
        const name = source.name || source.file;
        const isUnique = data.sources.every((other, m) => m === n || (other.name || other.file) !== name);
        return isUnique ? name : `${name} (${source.file}${data.sources.every((other, m) => m === n ||
            other.file !== source.file) ? "" : ", " + (n + 1)})`;
    });
    const searchKeys = [...new Set(data.sources.map(source => source.search_key).filter(isThere))];
    const searchKey = searchKeys.join(" or ");
    const figureAt = new Map(data.figures.map((figure, n) => [figure.name, n]));

    const points = data.points.map(([source, id, run, status, reason, smallest, monotonic, runs, note, axes, figures], n) =>
        ({index: n, isPoint: true, source, id, run, status, reason, smallest, monotonic, runs, note, axes, figures}));
    const simulations = data.simulations.map(([source, run, status, reason, looked, axes, figures], n) =>
        ({index: points.length + n, isPoint: false, source, id: run, run, status, reason, looked, axes, figures}));
    const entities = [...points, ...simulations];

    /// The names of scenario files without folder and ending, by file; empty unless all names differ.
    function shortNames(n) {
        const texts = [...new Set(points.map(item => item.axes[n]).filter(value => typeof value === "string"))];
        const names = new Map(texts.map(text => [text, text.replace(/^.*\/(?=[^/]+$)|\.ya?ml$/g, "")]));
        return new Set(names.values()).size === texts.length ? names : new Map();
    }
    const axisFields = data.axes.map((key, n) => {
        const names = key === "scenario" ? shortNames(n) : new Map();
        return {key: "axis:" + key, name: key, title: key,
                get: item => names.has(item.axes[n]) ? names.get(item.axes[n]) : item.axes[n]};
    });
    if (severalSources) {
        axisFields.unshift({key: "results", name: "results", title: "results", get: item => sourceNames[item.source]});
    }
    const figureFields = data.figures.map((figure, n) => ({
        key: "figure:" + figure.name, name: figure.name, title: figure.title, meaning: figure.meaning, unit: figure.unit,
        percent: figure.percent, get: item => item.figures[n]}));
    const smallestField = searchKey ? {key: "smallest", name: "smallest", title: "smallest " + searchKey,
                                       get: item => item.smallest} : null;
    const lookedField = searchKey ? {key: "looked", name: searchKey, title: searchKey, get: item => item.looked} : null;
    const statusField = {key: "status", name: "status", title: "status", get: item => item.status};
    const figureNamed = name => figureFields.find(field => field.name === name);
    const rateField = figureNamed("frames_per_second");
    const starvedField = figureNamed("starved_pixels");

    const valuesOf = (field, items) => inOrder(items.map(field.get));
    const isVaried = (field, items) => {
        let first;
        for (const item of items) {
            const value = field.get(item);
            if (!isThere(value)) continue;
            if (first === undefined) first = value;
            else if (value !== first) return true;
        }
        return false;
    };
    const hasValues = (field, items) => items.some(item => isThere(field.get(item)));
    const figureOf = (item, name) => figureAt.has(name) ? item.figures[figureAt.get(name)] : null;
    const isWhole = item => figureOf(item, "whole") !== 0;
    const shownValue = (field, value) => field.percent && isNumber(value) ? vega.format(".1~%")(value) : formatValue(value);

    const variedAxes = axisFields.filter(field => isVaried(field, points));
    /// The first of the axes that vary together with an axis: the value of each determines that of the other.
    const representative = new Map();
    for (const field of variedAxes) {
        const pairsWith = other => {
            const forth = new Map(), back = new Map();
            return points.every(item => {
                const [a, b] = [field.get(item), other.get(item)];
                if (!forth.has(a)) forth.set(a, b);
                if (!back.has(b)) back.set(b, a);
                return forth.get(a) === b && back.get(b) === a;
            });
        };
        const twin = variedAxes.slice(0, variedAxes.indexOf(field)).find(other =>
            representative.get(other) === other && pairsWith(other));
        representative.set(field, twin || field);
    }
    const ownAxes = variedAxes.filter(field => representative.get(field) === field);
    // Charts draw only numbers; the tables also have the figures that are words.
    const isDrawable = (field, items) => hasValues(field, items) &&
        items.every(item => typeof field.get(item) !== "string");
    const offeredFigures = (smallestField ? [smallestField] : []).concat(
        figureFields.filter(field => isDrawable(field, points)));

    function titleOf(item) {
        const what = item.isPoint ? `Point ${item.id}` : `Simulation ${item.id}`;
        return severalSources ? `${what} of ${sourceNames[item.source]}` : what;
    }
    /// A short name for a chart: the values of the settings that differ between points.
    const nameOf = item => [...variedAxes.map(field => field.get(item)), ...(smallestField && !item.isPoint ? [item.looked] : [])]
        .filter(isThere).map(formatValue).join(", ");
    function settingsOf(item) {
        const settings = data.axes.map((key, n) => [key, item.axes[n]]).filter(([, value]) => isThere(value));
        const key = data.sources[item.source].search_key;
        if (key && !item.isPoint) settings.push([key, item.looked]);
        return settings;
    }

    return {data, severalSources, searchKey, points, simulations, entities, axisFields, figureFields, smallestField,
            lookedField, statusField, figureNamed, rateField, starvedField, valuesOf, isVaried, hasValues, figureOf,
            isWhole, shownValue, variedAxes, representative, ownAxes, isDrawable, offeredFigures, titleOf, nameOf,
            settingsOf};
})();
