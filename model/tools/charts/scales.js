// What the kinds of charts have in common: values and their order, scales, axes, legends and marks. See charts.js.
const metabufferScales = (() => {
    "use strict";

    // The colours of Okabe and Ito, which colour-blind readers can distinguish, without those too pale for the
    // background.
    const themes = {
        light: {
            background: "#ffffff", text: "#1c2530", quiet: "#5b6672", line: "#aab3bd", grid: "#e6eaee",
            series: ["#0072b2", "#d55e00", "#009e73", "#c26a9d", "#c98a00", "#3f9fd6", "#4d4d4d"],
            good: "#0072b2", bad: "#d55e00", zero: "#eef1f4", absent: "#c3c9d0", sequence: [0, 0.85],
        },
        dark: {
            background: "#171c22", text: "#e3e8ee", quiet: "#9aa6b2", line: "#4d5864", grid: "#2a323b",
            series: ["#56b4e9", "#ff9d57", "#2fc79a", "#e08cbb", "#f0c541", "#8fa8ff", "#c4c4c4"],
            good: "#56b4e9", bad: "#ff9d57", zero: "#29323b", absent: "#4b5560", sequence: [0.3, 1],
        },
    };
    const shapes = ["circle", "square", "triangle-up", "diamond", "triangle-down", "cross", "triangle-right"];
    const dashes = [[1, 0], [6, 3], [2, 2], [8, 3, 2, 3]];
    const goodName = "whole pictures";
    const badName = "not whole: starved or rejected";
    const mostLegendEntries = 28;
    const mostTicksOfData = 12;
    const mostSymbols = 6000;

    const isNumber = value => typeof value === "number" && Number.isFinite(value);
    const isThere = value => value !== null && value !== undefined && value !== "";
    const distinct = values => [...new Set(values)];

    /// "number" if there are values and all of them are numbers, else "category".
    function kindOf(values) {
        const there = values.filter(isThere);
        return there.length > 0 && there.every(isNumber) ? "number" : "category";
    }

    const collator = new Intl.Collator("en", {numeric: true});
    function inOrder(values) {
        return distinct(values.filter(isThere)).sort((a, b) =>
            isNumber(a) && isNumber(b) ? a - b : isNumber(a) ? -1 : isNumber(b) ? 1 : collator.compare(a, b));
    }

    /// A loop, since the rows may be too many for the arguments of Math.min().
    function extent(values) {
        let least = Infinity, most = -Infinity;
        for (const value of values) {
            if (!isNumber(value)) continue;
            if (value < least) least = value;
            if (value > most) most = value;
        }
        return least <= most ? [least, most] : [0, 1];
    }

    /// Whether values grow by a factor rather than by a step: 32, 64, 128.
    function isGeometric(values) {
        const sorted = inOrder(values);
        if (sorted.length < 3 || sorted[0] <= 0) return false;
        const ratios = sorted.slice(1).map((value, n) => value / sorted[n]);
        const [least, most] = extent(ratios);
        return least >= 1.25 && most / least < 1.6 && sorted[sorted.length - 1] / sorted[0] >= 4;
    }

    function spansDecades(values) {
        const there = values.filter(value => isNumber(value) && value > 0);
        const [least, most] = extent(there);
        return there.length > 2 && there.length === values.filter(isThere).length && most / least > 50;
    }

    /// 1, 2, 5, 10, ... from at or below `least` to at or above `most`; powers of ten alone if that is more than `wanted`.
    function roundNumbers(least, most, wanted = 9) {
        const steps = [];
        for (let power = Math.floor(Math.log10(least)); power <= Math.ceil(Math.log10(most)); ++power)
            for (const digit of [1, 2, 5]) steps.push(Number((digit * 10 ** power).toPrecision(1)));
        const first = steps.filter(step => step <= least * 1.0000001).pop();
        const last = steps.find(step => step >= most * 0.9999999);
        const inside = steps.filter(step => step >= first && step <= last);
        const powers = inside.filter(step => Math.abs(Math.log10(step) % 1) < 1e-9);
        return {first, last, ticks: inside.length > wanted && powers.length > 1 ? powers : inside};
    }

    function formatNumber(value) {
        if (value === 0) return "0";
        const size = Math.abs(value);
        // Whole numbers are written in full, since every digit of a value that a search found matters.
        if (Number.isInteger(value) && size < 1e12) return vega.format(",d")(value);
        if (size >= 1e7) return vega.format(".4~s")(value);
        if (size < 1e-3) return vega.format(".3~e")(value);
        return vega.format(size >= 1000 ? ",.1~f" : ".4~g")(value);
    }
    const formatValue = value => isNumber(value) ? formatNumber(value) : isThere(value) ? String(value) : "–";

    const numberLabel = "datum.value == 0 ? '0' : abs(datum.value) >= 1e6 ? format(datum.value, '.4~s') : " +
        "abs(datum.value) < 1e-3 ? format(datum.value, '.2~e') : format(datum.value, ',.6~r')";
    const percentLabel = "format(datum.value, '.3~%')";

    /// Round numbers between `least` and `most`, about five.
    function evenNumbers(least, most) {
        const rough = (most - least) / 5;
        const power = 10 ** Math.floor(Math.log10(rough));
        const step = [1, 2, 5, 10].map(factor => factor * power).find(candidate => candidate >= rough * 0.9999);
        const ticks = [];
        for (let n = Math.ceil(least / step); n * step <= most * 1.0000001; ++n) ticks.push(Number((n * step).toPrecision(12)));
        return ticks;
    }

    /// Every second, third, ... of the ticks, so that at most `wanted` are left, or two if it is less.
    function thinned(ticks, wanted) {
        const step = Math.ceil(ticks.length / Math.max(2, wanted));
        return ticks.filter((_, n) => n % step === 0);
    }

    /// A scale for numbers with its ticks. The values decide its domain.
    function numberScale(name, range, values, axis, options) {
        const [least, most] = extent(values);
        const wanted = options.wanted || 9;
        const log = axis.log;
        if (log && least > 0) {
            if (options.ticksOfData && distinct(values).length <= mostTicksOfData)
                return {scale: {name, type: "log", domain: [least, most], range, padding: options.padding},
                        ticks: thinned(inOrder(values), wanted)};
            const round = roundNumbers(least, most, Math.min(9, wanted));
            return {scale: {name, type: "log", domain: [round.first, round.last], range}, ticks: round.ticks};
        }
        if (log && least >= 0 && most > 0) {  // a logarithmic axis has no zero, and a run without glitches has zero
            const there = values.filter(value => isNumber(value) && value > 0);
            const round = roundNumbers(Math.max(extent(there)[0], most / 1e6), most, Math.min(8, wanted));
            return {scale: {name, type: "symlog", constant: round.first, domain: [0, round.last], range},
                    ticks: [0, ...round.ticks]};
        }
        if (options.ticksOfData) {
            const there = inOrder(values);
            return {scale: {name, type: "linear", zero: false, domain: [least, most], range, padding: options.padding},
                    ticks: there.length <= mostTicksOfData ? thinned(there, wanted) : undefined};
        }
        const fromZero = options.zero || (least >= 0 && least < 0.4 * most);
        const nothing = least === most && !fromZero;
        return {scale: {name, type: "linear", nice: true, range, zero: false,
                        domain: [fromZero ? Math.min(0, least) : nothing ? least - 1 : least,
                                 nothing ? most + 1 : fromZero && most <= 0 ? 1 : most]}};
    }

    /// Where a chart is drawn: as the whole view, or as one of several panels.
    function areaOf(request, panelCount) {
        const {width, height} = request;
        if (panelCount <= 1) {
            return {single: true, columns: 1, w: {signal: "width"}, h: {signal: "height"}, across: "width",
                    upward: [{signal: "height"}, 0], mostWidth: width, mostHeight: height};
        }
        const mostColumns = Math.max(1, Math.min(panelCount, Math.floor(width / 270), 4));
        const rows = Math.ceil(panelCount / mostColumns);
        const columns = Math.ceil(panelCount / rows);  // four panels: two by two rather than three and one
        const names = inOrder(request.rows.map(row => row.x)).filter(value => !isNumber(value));
        const rowPadding = names.some(name => name.length > 6) ? 110 : 68;  // for the names below a panel
        const heights = request.chart === "heatmap" ? inOrder(request.rows.map(row => row.y)) : [];
        // For the names to the left of a panel.
        const columnPadding = Math.max(58, ...heights.map(name => formatValue(name).length * 7.4 + 22));
        const w = Math.max(110, Math.floor((width - 8) / columns - columnPadding - 2));
        const h = request.panelHeight || Math.max(110, Math.floor((height - 30) / rows - rowPadding));
        return {single: false, columns, rowPadding, columnPadding, w: {value: w}, h: {value: h}, across: [0, w], upward: [h, 0],
                mostWidth: w, mostHeight: h};
    }

    function config(theme, request) {
        const font = request.font || "sans-serif";
        const size = request.fontSize || 12;
        return {
            background: theme.background,
            title: {font, fontSize: size + 3, fontWeight: 600, color: theme.text, anchor: "start", offset: 12,
                    subtitleFont: font, subtitleFontSize: size, subtitleColor: theme.quiet, subtitlePadding: 4},
            axis: {labelFont: font, titleFont: font, labelFontSize: size - 1, titleFontSize: size, titleFontWeight: 500,
                   labelColor: theme.quiet, titleColor: theme.text, domainColor: theme.line, tickColor: theme.line,
                   gridColor: theme.grid, titlePadding: 8, tickSize: 4, labelLimit: request.labelLimit && 160,
                   titleLimit: 0, labelOverlap: "greedy"},
            legend: {labelFont: font, titleFont: font, labelFontSize: size - 1, titleFontSize: size - 1,
                     titleFontWeight: 600, labelColor: theme.text, titleColor: theme.text, labelLimit: request.labelLimit,
                     titleLimit: request.labelLimit, symbolStrokeWidth: 1.8, rowPadding: 4, columnPadding: 16, symbolSize: 70,
                     gradientLength: 140, gradientThickness: 12},
            text: {font, fontSize: size - 1, fill: theme.text},
        };
    }

    /// The labels of an axis of names: slanted if the names are too long to fit side by side.
    function nameLabels(names, area, legendWidth) {
        const longest = names.reduce((length, name) => Math.max(length, formatValue(name).length), 0);
        const room = (area.mostWidth - (area.single ? 60 + legendWidth : 0)) / Math.max(1, names.length);
        return longest * 6.8 + 8 > room ? {labelAngle: -35, labelAlign: "right", labelBaseline: "middle", labelOverlap: names.length > 30}
                                           : {labelOverlap: names.length > 30};
    }

    const besidePanels = request => new Set(request.rows.map(row => row.f)).size > 1;

    function legendPosition(request, entries) {
        if (request.width >= 620 && !besidePanels(request)) return {orient: "right", offset: 14, columns: entries > 20 ? 2 : 1};
        return {orient: "bottom", offset: 8, columns: Math.max(1, Math.floor(request.width / 210)), direction: "horizontal"};
    }

    /// The scales that distinguish series: colour and symbol, and dashes once all colours are used. If all series are
    /// numbers, their colours follow the order of the numbers.
    function seriesScales(request, theme, names, symbol) {
        const ordered = names.length > 2 && names.every(isNumber);
        const colours = ordered ? {scheme: "viridis", count: names.length, extent: theme.sequence}
                                : names.map((_, n) => theme.series[n % theme.series.length]);
        const scales = [
            {name: "colour", type: "ordinal", domain: names, range: colours},
            {name: "shape", type: "ordinal", domain: names, range: names.map((_, n) => shapes[(n + Math.floor(n / shapes.length)) % shapes.length])},
            {name: "dash", type: "ordinal", domain: names,
             range: names.map((_, n) => dashes[Math.floor(n / theme.series.length) % dashes.length])},
        ];
        const legends = [];
        const notes = [];
        if (names.length > mostLegendEntries) {
            notes.push(`${names.length} colours are too many for a legend`);
        } else if (names.length > 1 || (names.length === 1 && names[0] !== "")) {
            legends.push({
                ...(symbol === "square" ? {fill: "colour", symbolType: "square"}
                                        : {stroke: "colour", fill: "colour", shape: "shape"}),
                title: request.colour && request.colour.title || null, ...legendPosition(request, names.length),
            });
        }
        return {scales, legends, notes};
    }

    /// A row without a colour belongs to the series "", since Vega would print null as "null".
    const seriesOf = row => isThere(row.c) ? row.c : "";
    function seriesNamesOf(rows) {
        const names = inOrder(rows.map(row => row.c));
        return names.length && rows.every(row => isThere(row.c)) ? names : [...names, ""];
    }

    function axisLabels(axis, ticks, extra) {
        return {title: axis.title || null, encode: {labels: {update: {text: {
            signal: axis.percent ? percentLabel : numberLabel}}}}, ...extra, ...(ticks ? {values: ticks, tickCount: undefined} : {})};
    }

    /// The horizontal axis of rows: numbers on a continuous scale, texts side by side.
    function horizontal(request, area, rows, options = {}) {
        const values = rows.map(row => row.x).filter(isThere);
        const axis = {...request.x};
        if (kindOf(values) === "number") {
            if (axis.log === undefined) axis.log = isGeometric(values);
            const {scale, ticks} = numberScale("x", area.across, values, axis,
                                               {ticksOfData: options.ticksOfData, padding: 14,
                                                wanted: area.mostWidth / 40});
            return {scale, axis: axisLabels(axis, ticks, {orient: "bottom", scale: "x", grid: !options.ticksOfData,
                                                          tickCount: Math.max(3, Math.floor(area.mostWidth / 80))})};
        }
        const names = inOrder(values);
        return {scale: {name: "x", type: "point", domain: names, range: area.across, padding: 0.5},
                axis: {orient: "bottom", scale: "x", title: axis.title || null,
                       ...nameLabels(names, area, 60)}};
    }

    function vertical(request, area, values, options = {}) {
        const axis = {...request.y};
        if (axis.log === undefined) axis.log = options.mayBeLog && spansDecades(values);
        const all = values.concat(request.references.map(line => line.value));
        const upward = !options.roomAbove ? area.upward : [area.upward[0], 18];
        const {scale, ticks} = numberScale("y", upward, all, axis, {zero: options.zero, wanted: area.mostHeight / 24});
        return {scale, axis: axisLabels(axis, ticks, {orient: "left", scale: "y", grid: true,
                                                      tickCount: Math.max(3, Math.floor(area.mostHeight / 50))})};
    }

    function referenceMarks(request, area, theme, upright) {
        const data = {name: "references", values: request.references};
        const at = upright ? {x: {scale: "x", field: "value"}, y: {value: 0}, y2: area.h}
                           : {y: {scale: "y", field: "value"}, x: {value: 0}, x2: area.w};
        const text = upright ? {x: {scale: "x", field: "value", offset: 5}, y: {value: 4}, baseline: {value: "top"}}
                             : {x: {...area.w, offset: -4}, align: {value: "right"},
                                y: {scale: "y", field: "value", offset: -4}, baseline: {value: "bottom"}};
        return {data: request.references.length ? [data] : [], marks: request.references.length ? [
            {type: "rule", from: {data: "references"}, interactive: false, encode: {update: {
                ...at, stroke: {value: theme.text}, strokeWidth: {value: 1}, strokeDash: {value: [5, 4]}}}},
            {type: "text", from: {data: "references"}, interactive: false, encode: {update: {
                ...text, text: {field: "label"}, fill: {value: theme.text}}}},
        ] : []};
    }

    // The tooltip is a row with an id, for which the page shows the point, or a text, which the page shows as it is.
    const pointing = {tooltip: {signal: "datum.id == null ? datum.tip : datum"}, cursor: {signal: "datum.id == null ? 'default' : 'pointer'"}};

    /// One symbol for each row that has a position.
    function symbols(data, theme, options = {}) {
        const size = options.size || 46;
        return {type: "symbol", name: options.name || "points", from: {data}, encode: {
            enter: {x: {scale: "x", field: "x"}, y: {scale: "y", field: "y"}, ...pointing, ...options.enter},
            update: {size: {value: size}, stroke: {value: theme.background}, strokeWidth: {value: 0.8},
                     fillOpacity: {value: options.opacity || 1}, ...options.update},
            hover: {size: {value: size * 2.4}, fillOpacity: {value: 1}, stroke: {value: theme.text}},
        }};
    }

    /// Crosses at the top of the chart for rows without a value (unmet, failed).
    function lostMarks(data, theme) {
        return {type: "symbol", name: "lost", from: {data}, encode: {
            enter: {x: {scale: "x", field: "x"}, y: {value: 7}, shape: {value: "M-.5,-.5L.5,.5M.5,-.5L-.5,.5"},
                    ...pointing},
            update: {size: {value: 70}, stroke: {scale: "colour", field: "s"}, strokeWidth: {value: 1.8},
                     fill: {value: "transparent"}},
            hover: {size: {value: 160}, stroke: {value: theme.text}},
        }};
    }

    function markRow(row) {
        return {x: row.x, y: row.y, s: seriesOf(row), id: row.id === undefined ? null : row.id, tip: row.tip || null};
    }

    /// Mean and range of y by series and x. There is a gap where a series has rows at an x but no value.
    function meansOf(rows, decimals) {
        const groups = new Map();
        for (const row of rows) {
            const key = JSON.stringify([seriesOf(row), row.x]);
            if (!groups.has(key)) groups.set(key, {s: seriesOf(row), x: row.x, values: [], ids: []});
            const group = groups.get(key);
            if (isNumber(row.y)) group.values.push(row.y);
        }
        const order = new Map(inOrder(rows.map(row => row.x)).map((value, n) => [value, n]));
        return [...groups.values()].sort((a, b) => order.get(a.x) - order.get(b.x)).map(group => {
            const there = group.values.length > 0;
            const [lo, hi] = extent(group.values);
            return {s: group.s, x: group.x, n: group.values.length, there, lo: there ? lo : null, hi: there ? hi : null,
                    y: there ? group.values.reduce((sum, value) => sum + value, 0) / group.values.length : null,
                    decimals};
        });
    }

    function plural(count, thing) {
        return `${formatNumber(count)} ${thing}${count === 1 ? "" : "s"}`;
    }

    return {themes, goodName, badName, mostSymbols, isNumber, isThere, distinct, kindOf, inOrder, extent, spansDecades,
            roundNumbers, formatNumber, formatValue, numberLabel, percentLabel, evenNumbers, thinned, numberScale,
            areaOf, config, nameLabels, besidePanels, legendPosition, seriesScales, seriesOf, seriesNamesOf, axisLabels,
            horizontal, vertical, referenceMarks, pointing, symbols, lostMarks, markRow, meansOf, plural};
})();
