// Turns rows of results into specifications for Vega. Runs in the report page and, for `metabuffer plot`, in node.
//
// A request:
//   chart       "lines", "scatter", "heatmap", "pareto", "policy" or "histogram"
//   rows        [{x, y, c, f, whole, label, id, tip}], where x, y and c are numbers, texts or null
//                 x, y      the row's position
//                 c, f      what decides its colour, and its panel
//                 whole     false if its pictures are not (pareto, heatmap)
//                 label     its name on the front (pareto)
//                 id, tip   what the page shows for it
//   x, y, colour, facet: {title, log, percent}; log: true, false, or undefined to let the values decide
//   ownScales   whether each panel has its own vertical axis; the panels are then in the order of the rows
//   references  [{value, label}]: lines across the chart, at values on the axis of the figure
//   width, height, theme ("light", "dark"), font, fontSize, title
//
// Texts of rows are only ever data: they never get into the specification's expressions.
const metabufferCharts = (() => {
    "use strict";
    const {themes, goodName, badName, mostSymbols, isNumber, isThere, distinct, kindOf, inOrder, extent, spansDecades,
           roundNumbers, formatNumber, numberLabel, percentLabel, evenNumbers, thinned, numberScale, areaOf, config,
           nameLabels, besidePanels, legendPosition, seriesScales, seriesOf, seriesNamesOf, axisLabels, horizontal,
           vertical, referenceMarks, pointing, symbols, lostMarks, markRow, meansOf, plural} = metabufferScales;

    const builders = {};

    builders.lines = (request, area, theme, rows, panels) => {
        const names = seriesNamesOf(rows);
        const series = seriesScales(request, theme, names);
        const valued = rows.filter(row => isNumber(row.y));
        const lost = rows.filter(row => !isNumber(row.y));
        const x = horizontal(request, area, rows, {ticksOfData: true});
        const y = vertical(request, area, valued.map(row => row.y),
                           {mayBeLog: request.y.mayBeLog, roomAbove: lost.length > 0});
        const notes = [...series.notes];
        if (lost.length) notes.push(`× at the top: no value (${plural(lost.length, "point")})`);
        let spread = false;
        const panel = panelRows => {
            const means = meansOf(panelRows);
            const several = means.some(mean => mean.n > 1);
            spread = spread || several;
            const drawn = panelRows.filter(row => isNumber(row.y));
            const references = referenceMarks(request, area, theme, false);
            return {
                scales: [x.scale, y.scale], axes: [x.axis, y.axis],
                data: [{name: "means", values: means}, {name: "rows", values: drawn.map(markRow)},
                       {name: "gone", values: panelRows.filter(row => !isNumber(row.y)).map(markRow)},
                       ...references.data],
                marks: [
                    {type: "group", from: {facet: {name: "line", data: "means", groupby: "s"}}, interactive: false,
                     marks: [
                         ...(several ? [{type: "area", from: {data: "line"}, interactive: false, encode: {update: {
                             x: {scale: "x", field: "x"}, y: {scale: "y", field: "lo"}, y2: {scale: "y", field: "hi"},
                             defined: {field: "there"}, fill: {scale: "colour", field: "s"},
                             fillOpacity: {value: 0.13}}}}] : []),
                         {type: "line", from: {data: "line"}, interactive: false, encode: {update: {
                             x: {scale: "x", field: "x"}, y: {scale: "y", field: "y"}, defined: {field: "there"},
                             stroke: {scale: "colour", field: "s"}, strokeDash: {scale: "dash", field: "s"},
                             strokeWidth: {value: 2}, strokeJoin: {value: "round"}}}},
                     ]},
                    ...references.marks,
                    symbols("rows", theme, {
                        size: drawn.length > 600 ? 24 : 52, opacity: several ? 0.65 : 1,
                        enter: {fill: {scale: "colour", field: "s"}, shape: {scale: "shape", field: "s"}}}),
                    lostMarks("gone", theme),
                ],
            };
        };
        const drawnPanels = panels.map(panel);
        if (spread) notes.push("line: mean of the points at one position; band: from the least to the most");
        return {panels: drawnPanels, scales: series.scales, legends: series.legends, notes};
    };

    builders.scatter = (request, area, theme, rows, panels) => {
        const drawnRows = rows.filter(row => isNumber(row.y) && isThere(row.x));
        const names = seriesNamesOf(rows);
        const gradual = names.length > 8 && names.every(isNumber);
        const series = gradual
            ? {scales: [{name: "colour", type: "linear", domain: extent(names),
                         range: {scheme: "viridis", extent: theme.sequence}}],
               legends: [{fill: "colour", type: "gradient", title: request.colour.title || null,
                          orient: request.width >= 620 && !besidePanels(request) ? "right" : "bottom"}], notes: []}
            : seriesScales(request, theme, names);
        const x = horizontal(request, area, drawnRows);
        const y = vertical(request, area, drawnRows.map(row => row.y));
        const notes = [...series.notes];
        const lost = rows.length - drawnRows.length;
        if (lost) notes.push(`not shown: ${plural(lost, "point")} without a value`);
        const many = drawnRows.length > 400;
        return {panels: panels.map(panelRows => {
            const references = referenceMarks(request, area, theme, false);
            return {scales: [x.scale, y.scale], axes: [x.axis, y.axis],
                    data: [{name: "rows", values: panelRows.filter(row => isNumber(row.y) && isThere(row.x)).map(markRow)},
                           ...references.data],
                    marks: [...references.marks, symbols("rows", theme, {
                        size: many ? 26 : 52, opacity: many ? 0.6 : 0.85,
                        enter: {fill: {scale: "colour", field: "s"},
                                ...(gradual ? {} : {shape: {scale: "shape", field: "s"}})}})]};
        }), scales: series.scales, legends: series.legends, notes};
    };

    /// The front, by rising cost (x): the best row of each cost, if its y is higher than that of every cheaper row.
    function frontOf(rows) {
        const sorted = [...rows].sort((a, b) => a.x - b.x || b.y - a.y);
        const front = [];
        let best = -Infinity;
        for (const row of sorted) {
            if (row.y <= best) continue;
            best = row.y;
            front.push(row);
        }
        return front;
    }

    builders.pareto = (request, area, theme, rows, panels) => {
        const drawnRows = rows.filter(row => isNumber(row.x) && isNumber(row.y));
        const notes = [];
        const lost = rows.length - drawnRows.length;
        if (lost) notes.push(`not shown: ${plural(lost, "point")} without a value`);
        const nameOf = row => row.whole === false ? badName : goodName;
        const kinds = [goodName, badName].filter(kind => drawnRows.some(row => nameOf(row) === kind));
        const clean = drawnRows.some(row => row.whole !== false);
        if (!clean && drawnRows.length) notes.push("no point has whole pictures: the front is drawn through those without");
        let leftOut = 0;
        const x = horizontal({...request, x: {...request.x, log: request.x.log === undefined
            ? spansDecades(drawnRows.map(row => row.x)) : request.x.log}}, area, drawnRows);
        const y = vertical(request, area, drawnRows.map(row => row.y));
        const isBad = `datum.kind == '${badName}'`;
        const coloured = rows.some(row => isThere(row.c));
        const series = coloured ? seriesScales(request, theme, seriesNamesOf(rows), "square") : {scales: [], legends: [], notes: []};
        notes.push(...series.notes);
        const positionOfLabel = {  // no point is ever above and to the left of the front
            x: {scale: "x", field: "x"}, y: {scale: "y", field: "y"},
            align: {signal: `scale('x', datum.x) > ${area.mostWidth * 0.3} ? 'right' : 'left'`},
            dx: {signal: `scale('x', datum.x) > ${area.mostWidth * 0.3} ? -7 : 0`}, dy: {value: -8}};
        const drawnPanels = panels.map(panelRows => {
            const drawn = panelRows.filter(row => isNumber(row.x) && isNumber(row.y));
            const free = drawn.filter(row => row.whole !== false);
            const front = frontOf(free.length ? free : drawn);
            const onFront = new Set(front);
            const named = front.filter(row => isThere(row.label));
            const labels = thinned(named, Math.max(2, Math.floor(area.mostHeight / 26)));
            leftOut += named.length - labels.length;
            const references = referenceMarks(request, area, theme, false);
            const most = extent(drawn.map(row => row.x))[1];
            // The line goes on to the right: for a higher cost one gets at least as much.
            const line = front.map(row => ({x: row.x, y: row.y}));
            if (line.length && most > line[line.length - 1].x) line.push({x: most, y: line[line.length - 1].y});
            return {
                scales: [x.scale, y.scale], axes: [x.axis, y.axis],
                data: [{name: "steps", values: line},
                       {name: "rows", values: drawn.map(row => ({
                           ...markRow(row), kind: nameOf(row), front: onFront.has(row)}))
                           .sort((a, b) => a.front - b.front)},
                       {name: "labels", values: labels.map(row => ({x: row.x, y: row.y, text: String(row.label)}))},
                       ...references.data],
                marks: [
                    {type: "line", name: "front", from: {data: "steps"}, interactive: false, encode: {update: {
                        x: {scale: "x", field: "x"}, y: {scale: "y", field: "y"}, interpolate: {value: "step-after"},
                        stroke: {value: theme.text}, strokeWidth: {value: 1.6}}}},
                    ...references.marks,
                    symbols("rows", theme, {
                        size: drawn.length > 400 ? 30 : 56,
                        enter: {shape: {scale: "kindShape", field: "kind"},
                                fill: coloured ? {scale: "colour", field: "s"} : {scale: "kindColour", field: "kind"}},
                        update: {fillOpacity: {signal: isBad + " ? 0.35 : datum.front ? 1 : 0.6"},
                                 stroke: {signal: `datum.front ? '${theme.text}' : ${isBad} ? '${theme.bad}' : ` +
                                                  `'${theme.background}'`},
                                 strokeWidth: {signal: "datum.front ? 1.5 : 0.8"}}}),
                    {type: "text", name: "names", from: {data: "labels"}, interactive: false, encode: {update: {
                        ...positionOfLabel, text: {field: "text"}, limit: {value: area.mostWidth * 0.55}, fill: {value: theme.text}}}},
                ],
            };
        });
        return {panels: drawnPanels, scales: [
            ...series.scales,
            {name: "kindColour", type: "ordinal", domain: kinds,
             range: kinds.map(kind => kind === badName ? theme.bad : theme.good)},
            {name: "kindShape", type: "ordinal", domain: kinds,
             range: kinds.map(kind => kind === badName ? "triangle-up" : "circle")},
        ], legends: [...(kinds.length ? [{...(coloured ? {} : {fill: "kindColour"}), shape: "kindShape", title: null,
                                          ...legendPosition(request, 2)}] : []), ...series.legends],
        notes: drawnRows.length ? ["line: the front, the cheapest of each value", ...notes,
                                   ...(leftOut > 0 ? [`${plural(leftOut, "name")} of the front left out`] : [])] : notes};
    };

    builders.heatmap = (request, area, theme, rows, panels) => {
        const columns = inOrder(rows.map(row => row.x));
        const lines = inOrder(rows.map(row => row.y));
        if (kindOf(lines) === "category") lines.reverse();  // texts are read from the top; numbers grow upwards
        let mostInCell = 0;
        let anyNotWhole = false;
        let lost = 0;
        const cells = panels.map(panelRows => {
            const groups = new Map();
            for (const row of panelRows) {
                if (!isThere(row.x) || !isThere(row.y)) continue;
                const key = JSON.stringify([row.x, row.y]);
                if (!groups.has(key)) groups.set(key, []);
                groups.get(key).push(row);
            }
            return [...groups.values()].map(group => {
                const values = group.map(row => row.c).filter(isNumber);
                mostInCell = Math.max(mostInCell, group.length);
                if (!values.length) ++lost;
                const mean = values.length ? values.reduce((sum, value) => sum + value, 0) / values.length : null;
                const only = group.length === 1 ? group[0] : null;
                const notWhole = group.some(row => row.whole === false);
                anyNotWhole = anyNotWhole || notWhole;
                const label = mean === null ? "×" : request.colour.percent
                    ? vega.format(".3~%")(mean) : formatNumber(Number.isInteger(mean) ? mean : Number(mean.toPrecision(4)));
                return {x: group[0].x, y: group[0].y, v: mean, text: label, notWhole, id: only && only.id !== undefined ? only.id : null,
                        tip: only ? only.tip || null : `${plural(group.length, "point")}: mean ${label}` +
                            (values.length ? `, ${formatNumber(extent(values)[0])} to ${formatNumber(extent(values)[1])}` : "") +
                            (values.length < group.length ? `, ${group.length - values.length} without a value` : "")};
            });
        });
        const values = cells.flat().map(cell => cell.v).filter(isNumber);
        const [least, most] = extent(values);
        const countsBadness = least === 0 && most > 0;
        const uneven = request.colour.log !== false && least >= 0 && most > 0 &&
            (request.colour.log || most / Math.max(least, most / 1e6) > 100 && values.length > 3);
        const round = uneven ? roundNumbers(extent(values.filter(value => value > 0))[0], most) : null;
        const scale = {name: "colour", domain: round ? [round.first, round.last] : [least, least < most ? most : least + 1],
                       type: uneven ? "log" : "linear",
                       range: countsBadness ? {scheme: "yelloworangered", extent: [0.12, 0.95]}
                                            : {scheme: "viridis", extent: [0.08, 1]}};
        const besideLegend = request.width >= 620 && area.single ? 120 : 0;
        const longest = cells.flat().reduce((length, cell) => Math.max(length, cell.text.length), 0);
        const roomAcross = area.mostWidth * (area.single ? 0.72 : 1) / Math.max(1, columns.length);
        const withText = roomAcross > longest * 6.6 + 4 && area.mostHeight / Math.max(1, lines.length) > 17;
        const zero = countsBadness ? [{test: "datum.v === 0", value: theme.zero}] : [];
        const labels = {update: {text: {signal: "isNumber(datum.value) ? " + numberLabel + " : datum.value"}}};
        const cornerSide = "clamp(min(bandwidth('x'), bandwidth('y')) * 0.4, 3, 10)";
        const notes = [];
        if (mostInCell > 1) notes.push(`each field is the mean of up to ${plural(mostInCell, "point")}`);
        if (countsBadness) notes.push("pale: zero");
        if (anyNotWhole) notes.push("corner: not whole, since pixels starved, or frames or rows were rejected");
        if (lost) notes.push("×: no value");
        return {panels: cells.map(panelCells => ({
            scales: [{name: "x", type: "band", domain: columns, range: area.across, padding: 0.03},
                     {name: "y", type: "band", domain: lines, range: area.upward, padding: 0.03}],
            axes: [{orient: "bottom", scale: "x", title: request.x.title || null, domain: false, ticks: false,
                    labelPadding: 6, encode: {labels}, ...nameLabels(columns, area, besideLegend)},
                   {orient: "left", scale: "y", title: request.y.title || null, domain: false, ticks: false,
                    labelPadding: 6, encode: {labels}}],
            data: [{name: "fields", values: panelCells}, {name: "notWhole", values: panelCells.filter(cell => cell.notWhole)}],
            marks: [
                {type: "rect", name: "cells", from: {data: "fields"}, encode: {
                    enter: {x: {scale: "x", field: "x"}, width: {scale: "x", band: 1}, y: {scale: "y", field: "y"},
                            height: {scale: "y", band: 1}, cornerRadius: {value: 1}, ...pointing},
                    update: {fill: [{test: "!isNumber(datum.v)", value: theme.absent}, ...zero,
                                    {scale: "colour", field: "v"}], stroke: {value: "transparent"}, strokeWidth: {value: 2}},
                    hover: {stroke: {value: theme.text}},
                }},
                {type: "symbol", name: "corners", from: {data: "notWhole"}, interactive: false, encode: {update: {
                    shape: {value: "M-1,-1L1,-1L1,1Z"}, size: {signal: `${cornerSide} * ${cornerSide}`},
                    x: {scale: "x", field: "x", band: 1, offset: {signal: `-${cornerSide} / 2`}},
                    y: {scale: "y", field: "y", offset: {signal: `${cornerSide} / 2`}},
                    fill: {value: theme.text}, stroke: {value: theme.background}, strokeWidth: {value: 0.5}}}},
                ...(withText ? [{type: "text", from: {data: "fields"}, interactive: false, encode: {update: {
                    x: {scale: "x", field: "x", band: 0.5}, y: {scale: "y", field: "y", band: 0.5},
                    align: {value: "center"}, baseline: {value: "middle"}, text: {field: "text"},
                    fill: [{test: "!isNumber(datum.v)", value: theme.text},
                           ...zero.map(rule => ({...rule, value: theme.quiet})),
                           {signal: "luminance(scale('colour', datum.v)) > 0.4 ? '#15191d' : '#ffffff'"}]}}}] : []),
            ],
        })), scales: [scale], legends: values.length && least < most ? [{
            fill: "colour", type: "gradient", title: request.colour.title || null,
            values: round ? round.ticks : evenNumbers(least, most),
            encode: {labels: {update: {text: {signal: request.colour.percent ? percentLabel : numberLabel}}}},
            ...(request.width >= 620 && !besidePanels(request) ? {orient: "right", offset: 14} : {orient: "bottom", offset: 8, direction: "horizontal", gradientLength: Math.min(300, request.width / 2)})}] : [],
        notes};
    };

    /// One bar for each category, its height the mean, with every point on it.
    builders.policy = (request, area, theme, rows, panels) => {
        const valued = rows.filter(row => isNumber(row.y) && isThere(row.x));
        const names = inOrder(rows.map(row => row.x));
        const coloured = rows.some(row => isThere(row.c));
        const seriesNames = coloured ? seriesNamesOf(rows) : names;
        const series = seriesScales(coloured ? request : {...request, colour: null}, theme, seriesNames, "square");
        const notes = [...series.notes];
        if (valued.length > names.length) notes.push("bar: mean; line: from the least to the most; circles: the points");
        const panelOf = panelRows => {
            const drawn = panelRows.filter(row => isNumber(row.y) && isThere(row.x)).slice(0, mostSymbols)
                .map(row => ({...markRow(row), s: coloured ? seriesOf(row) : row.x}));
            const means = meansOf(drawn.map(row => ({x: row.x, y: row.y, c: row.s})));
            for (const mean of means) {
                mean.id = null;
                mean.tip = `${coloured ? mean.x + ", " + mean.s : mean.x}: mean ${formatNumber(Number(mean.y.toPrecision(4)))} of ` +
                    `${plural(mean.n, "point")}, ${formatNumber(mean.lo)} to ${formatNumber(mean.hi)}`;
            }
            const own = request.ownScales ? drawn : valued;
            const y = vertical({...request, y: {...request.y, ...(panelRows[0] && panelRows[0].axis)}}, area,
                               own.map(row => row.y), {zero: true});
            // The points of a bar lie side by side, in the order of their rows.
            const counts = new Map();
            for (const row of drawn) counts.set(row.x + "\n" + row.s, (counts.get(row.x + "\n" + row.s) || 0) + 1);
            const seen = new Map();
            for (const row of drawn) {
                const key = row.x + "\n" + row.s;
                seen.set(key, (seen.get(key) || 0) + 1);
                row.along = seen.get(key) / (counts.get(key) + 1);
            }
            const bandOf = coloured ? "scale('x', datum.x) + scale('in', datum.s)" : "scale('x', datum.x)";
            const bandwidth = coloured ? "bandwidth('in')" : "bandwidth('x')";
            const references = referenceMarks(request, area, theme, false);
            const x = {name: "x", type: "band", domain: names, range: area.across, padding: 0.28};
            return {
                scales: [x, y.scale, ...(coloured ? [{name: "in", type: "band", domain: seriesNames, padding: 0.06,
                                                      range: [0, {signal: "bandwidth('x')"}]}] : [])],
                axes: [{orient: "bottom", scale: "x", title: request.x.title || null, ticks: false, labelPadding: 6,
                        ...nameLabels(names, area, coloured && request.width >= 620 ? 120 : 0)}, y.axis],
                data: [{name: "means", values: means}, {name: "rows", values: drawn}, ...references.data],
                marks: [
                    {type: "rect", name: "bars", from: {data: "means"}, encode: {
                        enter: {x: {signal: bandOf}, width: {signal: bandwidth}, y: {scale: "y", field: "y"},
                                y2: {scale: "y", value: 0}, ...pointing},
                        update: {fill: {scale: "colour", field: "s"}, fillOpacity: {value: 0.55}},
                        hover: {fillOpacity: {value: 0.8}}}},
                    {type: "rule", from: {data: "means"}, interactive: false, encode: {update: {
                        x: {signal: `${bandOf} + ${bandwidth} / 2`}, y: {scale: "y", field: "lo"},
                        y2: {scale: "y", field: "hi"}, stroke: {value: theme.text}, strokeWidth: {value: 1.4}}}},
                    ...(valued.length > names.length ? [{type: "symbol", name: "points", from: {data: "rows"}, encode: {
                        enter: {x: {signal: `${bandOf} + ${bandwidth} * datum.along`}, y: {scale: "y", field: "y"},
                                ...pointing},
                        update: {size: {value: drawn.length > 300 ? 12 : 30}, fill: {scale: "colour", field: "s"},
                                 stroke: {value: theme.background}, strokeWidth: {value: 0.6},
                                 fillOpacity: {value: 0.9}},
                        hover: {size: {value: 90}, stroke: {value: theme.text}}}}] : []),
                    ...references.marks,
                ],
            };
        };
        return {panels: panels.map(panelOf), scales: series.scales, legends: coloured ? series.legends : [], notes};
    };

    builders.histogram = (request, area, theme, rows, panels) => {
        const there = rows.filter(row => isNumber(row.x));
        const names = seriesNamesOf(rows);
        const series = seriesScales(request, theme, names, "square");
        const values = there.map(row => row.x);
        const log = request.x.log && extent(values)[0] > 0;
        const onto = log ? Math.log10 : value => value;
        const back = log ? value => 10 ** value : value => value;
        const [least, most] = extent(values.map(onto));
        const wanted = Math.max(8, Math.min(40, Math.ceil(Math.sqrt(there.length) * 1.5)));
        const rough = (most - least || 1) / wanted;
        const power = 10 ** Math.floor(Math.log10(rough));
        let step = [1, 2, 2.5, 5, 10].map(factor => factor * power).find(candidate => candidate >= rough * 0.9999);
        if (!log && values.every(Number.isInteger)) step = Math.max(1, Math.round(step));
        const first = Math.floor(least / step) * step;
        const count = Math.floor((most - first) / step + 1e-9) + 1;
        const binned = panels.map(panelRows => {
            const bins = new Map();
            for (const row of panelRows) {
                if (!isNumber(row.x)) continue;
                const n = Math.min(count - 1, Math.floor((onto(row.x) - first) / step + 1e-9));
                const key = n + "\n" + seriesOf(row);
                if (!bins.has(key)) bins.set(key, {n, s: seriesOf(row), count: 0});
                ++bins.get(key).count;
            }
            const heights = new Map();
            return names.flatMap(name => [...bins.values()].filter(bin => bin.s === name)).map(bin => {
                const from = heights.get(bin.n) || 0;
                heights.set(bin.n, from + bin.count);
                const x0 = back(first + bin.n * step), x1 = back(first + (bin.n + 1) * step);
                return {x0, x1, y0: from, y1: from + bin.count, s: bin.s, id: null,
                        tip: `${formatNumber(x0)} to ${formatNumber(x1)}: ${plural(bin.count, "point")}`};
            });
        });
        const edges = [back(first), back(first + count * step)];
        const lines = request.references.map(line => line.value);
        const x = numberScale("x", area.across, [...edges, ...lines], {log}, {});
        if (!log) x.scale = {...x.scale, domain: extent([...edges, ...lines]), nice: false};
        const y = vertical({...request, references: []}, area, binned.flat().map(bin => bin.y1), {zero: true});
        const notes = [...series.notes];
        if (there.length < rows.length) notes.push(`not shown: ${plural(rows.length - there.length, "point")} without a value`);
        return {panels: binned.map(bins => {
            const references = referenceMarks(request, area, theme, true);
            return {
                scales: [x.scale, y.scale],
                axes: [axisLabels(request.x, x.ticks, {orient: "bottom", scale: "x",
                                                       tickCount: Math.max(3, Math.floor(area.mostWidth / 80))}), y.axis],
                data: [{name: "counts", values: bins}, ...references.data],
                marks: [{type: "rect", name: "bins", from: {data: "counts"}, encode: {
                    enter: {x: {scale: "x", field: "x0", offset: 0.5}, x2: {scale: "x", field: "x1", offset: -0.5},
                            y: {scale: "y", field: "y1"}, y2: {scale: "y", field: "y0"}, ...pointing},
                    update: {fill: {scale: "colour", field: "s"}, fillOpacity: {value: 0.85}},
                    hover: {fillOpacity: {value: 1}}}}, ...references.marks],
            };
        }), scales: series.scales, legends: series.legends, notes};
    };

    /// Replaces scenario files among the texts by their names, without folder and ending, if the names still differ.
    function withShortNames(rows) {
        const short = text => text.replace(/(?:[^\s,]*\/)?([^\s,/]+)\.ya?ml(?=$|,)/g, "$1");
        let result = rows;
        for (const field of ["x", "y", "c", "f", "label"]) {
            const texts = distinct(rows.map(row => row[field]).filter(value => typeof value === "string"));
            const names = new Map(texts.map(text => [text, short(text)]));
            if (texts.every(text => names.get(text) === text) || distinct([...names.values()]).length < texts.length) continue;
            result = result.map(row => names.has(row[field]) ? {...row, [field]: names.get(row[field])} : row);
        }
        return result;
    }

    /// Returns {spec, notes}: the specification, and what a reader should know about the picture.
    function build(input) {
        const request = {width: 720, height: 440, theme: "light", references: [], labelLimit: 260, ...input, rows: withShortNames(input.rows)};
        const positionless = ["lines", "heatmap", "policy"].includes(request.chart)
            ? request.rows.filter(row => !isThere(row.x)).length : 0;
        if (positionless) request.rows = request.rows.filter(row => isThere(row.x));
        request.x = request.x || {};
        request.y = request.y || {};
        request.colour = request.colour || {};
        const theme = themes[request.theme];
        const facetValues = request.rows.map(row => row.f);
        const facets = request.ownScales ? distinct(facetValues) : inOrder(facetValues);
        const panels = facets.length > 1 ? facets.map(facet => request.rows.filter(row => row.f === facet)) : [request.rows];
        const area = areaOf(request, panels.length);
        const built = builders[request.chart](request, area, theme, request.rows, panels);
        if (positionless) built.notes.push(`not shown: ${plural(positionless, "point")} without a position on the horizontal axis`);
        const spec = {
            description: request.description || request.title || "",
            background: theme.background, padding: request.padding || 6, config: config(theme, request),
            scales: built.scales, legends: built.legends,
        };
        // The title of the vertical axes is written once, above the panels: next to them there may be no room.
        const upward = !area.single && request.y.title ? ["↑ " + request.y.title] : [];
        const lines = [...(request.notesBelowTitle && built.notes.length ? [built.notes.join("; ")] : []), ...upward];
        if (request.title) {
            spec.title = {text: request.title, ...(lines.length ? {subtitle: lines} : {})};
        } else if (lines.length) {
            spec.title = {text: lines, fontSize: request.fontSize || 12, fontWeight: 400, color: theme.text};
        }
        if (area.single) {
            const [panel] = built.panels;
            Object.assign(spec, {width: request.width, height: request.height,
                                 autosize: {type: "fit", contains: "padding"}, data: panel.data, axes: panel.axes,
                                 scales: [...built.scales, ...panel.scales], marks: panel.marks});
        } else {
            spec.autosize = "pad";
            spec.layout = {columns: area.columns, padding: {row: area.rowPadding, column: area.columnPadding}, bounds: "flush", align: "all"};
            const facetTitle = request.facet && request.facet.title;
            spec.marks = built.panels.map((panel, n) => {
                const lastOfColumn = n + area.columns >= built.panels.length;
                return {
                    type: "group", encode: {update: {width: area.w, height: area.h}},
                    title: {text: facetTitle ? `${facetTitle} ${facets[n]}` : String(facets[n]), fontSize: request.fontSize || 12,
                            fontWeight: 600, anchor: "start", offset: 6, frame: "group"},
                    data: panel.data, scales: panel.scales, marks: panel.marks,
                    axes: panel.axes.map(axis => {
                        const isTitled = axis.orient === "bottom" && lastOfColumn;
                        return {...axis, title: isTitled ? axis.title : null};
                    }),
                };
            });
        }
        return {spec, notes: built.notes};
    }

    return {build};
})();
