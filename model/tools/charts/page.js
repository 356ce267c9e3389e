// The report page. Everything from the results is data: it reaches the document as text, never as markup.
(() => {
    "use strict";
    const {kindOf, inOrder, formatValue, isNumber, isThere} = metabufferScales;
    const {build} = metabufferCharts;
    const {element} = metabufferElements;
    const {data, severalSources, searchKey, points, simulations, entities, axisFields, figureFields, smallestField,
           lookedField, statusField, figureNamed, rateField, starvedField, valuesOf, isVaried, hasValues, figureOf,
           isWhole, shownValue, variedAxes, representative, ownAxes, isDrawable, offeredFigures, titleOf, nameOf,
           settingsOf} = metabufferResults;
    const {pairs, reportPart, picturesPart, commandPart} = metabufferPoint;
    const byId = id => document.getElementById(id);

    const mostRowsAtOnce = 200;     // of the table, until the reader asks for more
    const mostSvgMarks = 1500;      // charts with more use a canvas: many elements make a browser slow
    const mostLines = 12;           // charts with more would be unreadable, and show means instead
    const mostPanels = 12;
    const mostColours = 28;         // values of an axis that gives the colours by default
    const mostFields = 150;         // of a heat map, in one direction
    const mostFilterValues = 60;

    const counted = (count, thing) => `${formatValue(count)} ${thing}${count === 1 ? "" : "s"}`;

    // --------------------------------------------------------------------------------------------------------- filters

    const filters = new Map();  // by an axis field's key, the only value that is shown
    const passes = item => axisFields.every(field => !filters.has(field.key) || field.get(item) === filters.get(field.key));
    let shownPoints = points;
    let shownSimulations = simulations;

    /// A choice among values. These are data, so the options are identified by their indices in the list.
    function choice(label, options, chosen, onchange) {
        const select = element("select", {onchange: () => onchange(options[select.selectedIndex].value)});
        options.forEach(option => select.append(element("option", {}, option.label)));
        select.selectedIndex = Math.max(0, options.findIndex(option => option.value === chosen));
        return element("label", {}, label, select);
    }

    function buildFilters() {
        const form = byId("filters");
        form.addEventListener("submit", event => event.preventDefault());
        const fields = variedAxes.filter(field => valuesOf(field, points).length <= mostFilterValues);
        if (points.length < 2 || !fields.length) return;
        form.hidden = false;
        for (const field of fields) {
            const all = {label: "all", value: undefined};
            const values = valuesOf(field, points).map(value => ({label: formatValue(value), value}));
            form.append(choice(field.title, [all, ...values], undefined, value => {
                if (value === undefined) filters.delete(field.key);
                else filters.set(field.key, value);
                shownPoints = points.filter(passes);
                shownSimulations = simulations.filter(passes);
                charts.forEach(chart => chart.refresh());
                refreshTable();
            }));
        }
    }

    // --------------------------------------------------------------------------------------------------------- tooltip

    const tooltip = byId("tooltip");
    function showTooltip(handler, event, item, value) {
        if (value === null || value === undefined || value === "") {
            tooltip.hidden = true;
            return;
        }
        tooltip.replaceChildren();
        const entity = typeof value === "object" ? entities[value.id] : null;
        if (entity) {
            const rows = settingsOf(entity);
            if (entity.status !== "done") rows.push(["status", entity.status]);
            if (smallestField && entity.isPoint) rows.push([smallestField.title, smallestField.get(entity)]);
            for (const name of ["rejected_rows", "rejected_frames"]) {
                if (figureOf(entity, name) > 0) rows.push([figureNamed(name).title, figureOf(entity, name)]);
            }
            for (const field of [starvedField, rateField, figureNamed("utilization"), figureNamed("recovered_slots")]) {
                if (field && isThere(field.get(entity))) rows.push([field.title, shownValue(field, field.get(entity))]);
            }
            for (const field of handler.fields || []) {
                if (!rows.some(([title]) => title === field.title) && isThere(field.get(entity))) {
                    rows.push([field.title, shownValue(field, field.get(entity))]);
                }
            }
            tooltip.append(element("b", {}, titleOf(entity)), element("table", {}, element("tbody", {}, ...rows.map(
                ([title, shown]) => element("tr", {}, element("td", {}, title), element("td", {}, formatValue(shown)))))));
            if (entity.reason) tooltip.append(element("div", {}, entity.reason));
            tooltip.append(element("div", {class: "hint"}, "click for the whole report"));
        } else {
            tooltip.append(String(value));
        }
        tooltip.hidden = false;
        const box = tooltip.getBoundingClientRect();
        const right = event.clientX + 14 + box.width < window.innerWidth;
        const below = event.clientY + 14 + box.height < window.innerHeight;
        const left = right ? event.clientX + 14 : Math.max(4, event.clientX - box.width - 10);
        tooltip.style.left = Math.max(4, Math.min(left, window.innerWidth - box.width - 4)) + "px";
        tooltip.style.top = Math.max(4, below ? event.clientY + 14 : event.clientY - box.height - 10) + "px";
    }
    window.addEventListener("scroll", () => { tooltip.hidden = true; }, {passive: true});

    // ---------------------------------------------------------------------------------------------------------- charts

    const darkness = window.matchMedia("(prefers-color-scheme: dark)");
    const charts = [];

    /// A box on the page in which Vega draws what `request` returns: {chart, rows, x, y, ..., fields} or {words}.
    class Chart {
        constructor(id, label, request, height) {
            this.request = request;
            this.height = height;
            this.box = element("div", {class: "chart", id: "chart-" + id, role: "img", "aria-label": label});
            this.caption = element("figcaption");
            this.figure = element("figure", {}, this.box, this.caption);
            this.waiting = false;
            charts.push(this);
        }

        /// Draws soon, but not at once, so that the page responds to the user between two charts.
        refresh() {
            if (this.waiting) return;
            this.waiting = true;
            setTimeout(() => {
                this.waiting = false;
                this.draw();
            });
        }

        draw(narrower = 0) {
            if (this.view) this.view.finalize();
            this.view = null;
            tooltip.hidden = true;
            const request = this.request();
            this.box.replaceChildren();
            if (!request.words && !request.rows.length) request.words = "No point is left by the choices above.";
            if (request.words) {
                this.box.append(element("p", {class: "what"}, request.words));
                this.caption.textContent = "";
                this.box.dataset.drawn = "yes";
                return;
            }
            const width = Math.max(240, Math.floor(this.box.clientWidth) - narrower);
            const panels = new Set(request.rows.map(row => row.f)).size;
            const narrow = width < 620;
            const {spec, notes} = build({
                theme: darkness.matches ? "dark" : "light", font: getComputedStyle(document.documentElement).fontFamily,
                fontSize: 12, ...request, width, panelHeight: panels > 1 ? 190 : undefined,
                height: this.height + (narrow ? 60 : 0), padding: narrow ? 2 : 6});
            spec.description = "";
            const handler = {fields: request.fields};
            const view = new vega.View(vega.parse(spec), {
                renderer: request.rows.length > mostSvgMarks ? "canvas" : "svg", container: this.box, hover: true,
                logLevel: vega.Warn, tooltip: (_, event, item, value) => showTooltip(handler, event, item, value)});
            view.addEventListener("click", (event, item) => {
                const id = item && item.datum ? item.datum.id : undefined;
                if (isNumber(id) && entities[id]) openPanel(entities[id]);
            });
            this.view = view;
            this.caption.textContent = notes.map(note => note[0].toUpperCase() + note.slice(1) + ".").join(" ");
            this.box.dataset.drawn = "no";
            view.runAsync().then(() => {
                // The size of legends and titles around several panels is known only now.
                const excess = this.box.scrollWidth - this.box.clientWidth;
                if (excess > 0 && narrower === 0 && panels > 1) this.draw(excess);
                else this.box.dataset.drawn = "yes";
            });
        }
    }

    const axisTitle = (field, log) => ({title: field.title, percent: field.percent, log});
    const optionsOf = fields => fields.map(field => ({label: field.title, value: field}));
    const noField = {key: "", title: "", get: () => null};

    /// The settings that are not drawn in another way, as one text: "irsa, 32".
    function othersField(taken) {
        const drawn = taken.map(field => representative.get(field));
        const others = ownAxes.filter(field => !drawn.includes(field) && !filters.has(field.key));
        if (!others.length) return noField;
        if (others.length === 1) return others[0];
        return {key: "others", title: others.map(field => field.title).join(", "),
                get: item => others.map(field => formatValue(field.get(item))).join(", ")};
    }
    function rowsOf(items, {x, y, c, f, more}) {
        return items.map(item => ({x: x.get(item), y: y ? y.get(item) : null, c: c ? c.get(item) : null,
                                   f: f ? f.get(item) : null, id: item.index, ...(more ? more(item) : {})}));
    }
    function section(id, title, what, controls, ...content) {
        byId("charts").append(element("section", {id: "section-" + id, "aria-labelledby": "title-" + id},
            element("h2", {id: "title-" + id}, title), what ? element("p", {class: "what"}, what) : null,
            controls.length ? element("div", {class: "controls"}, ...controls) : null, ...content));
    }
    const leftOut = [];

    const numericAxes = variedAxes.filter(field => kindOf(points.map(field.get)) === "number");
    const valueCount = field => valuesOf(field, points).length;
    /// The axis to draw over: the bus's width if it has enough values for a curve, else the numeric axis with most
    /// values.
    const firstNumericAxis = numericAxes.find(field => field.name === "bus.width_bits" && valueCount(field) > 2) ||
        numericAxes.reduce((best, field) => best && valueCount(best) >= valueCount(field) ? best : field, undefined);
    const panelFields = variedAxes.filter(field => valuesOf(field, points).length <= mostPanels);
    const scaleChoice = (state, chart) => choice("scale", [{label: "linear", value: false}, {label: "logarithmic", value: true}],
                                                 state.log, log => { state.log = log; chart.refresh(); });
    /// The default is a colour for each combination of the axes that are not drawn in another way, unless these are too
    /// many.
    const allOthers = {key: "others", title: "all other axes"};
    const colourOf = state => state.colour === allOthers ? othersField([state.x, state.panels]) : state.colour;
    function usualColour(state) {
        const all = othersField([state.x, state.panels]);
        if (all === noField || valuesOf(all, points).length <= mostLines) return allOthers;
        const rest = ownAxes.filter(field => field !== representative.get(state.x) && field !== state.panels &&
            valueCount(field) <= mostColours);
        return rest.find(field => kindOf(points.map(field.get)) === "category") || rest[0] || noField;
    }
    const colourChoice = (state, chart) => choice("colour", [
        ...(variedAxes.length > 1 ? [{label: allOthers.title, value: allOthers}] : []), {label: "none", value: noField},
        ...optionsOf([...variedAxes, statusField])], state.colour, field => { state.colour = field; chart.refresh(); });
    const panelOptions = [{label: "one chart", value: noField}, ...optionsOf(panelFields)];

    /// If there are too many lines for one chart: panels by scenario, else by the first axis with few values.
    function usualPanels(x) {
        const others = ownAxes.filter(field => field !== representative.get(x));
        const lines = others.reduce((count, field) => count * valuesOf(field, points).length, 1);
        if (lines <= 8 || others.length < 2) return noField;
        const candidates = others.filter(field => panelFields.includes(field));
        return candidates.find(field => field.name === "scenario") || candidates[0] || noField;
    }

    function addSmallest() {
        if (!smallestField) {
            leftOut.push("Smallest value against an axis: these results are not of a search.");
            return;
        }
        if (!variedAxes.length) {
            leftOut.push(`Smallest ${searchKey} against an axis: no axis has more than one value.`);
            return;
        }
        const state = {x: firstNumericAxis || variedAxes[0]};
        state.panels = usualPanels(state.x);
        state.colour = usualColour(state);
        const chart = new Chart("smallest", `Smallest ${searchKey} against an axis, a line for each other setting`, () => ({
            chart: "lines", x: axisTitle(state.x), y: {title: smallestField.title, mayBeLog: true},
            colour: {title: colourOf(state).title}, facet: {title: state.panels.title}, fields: [smallestField],
            rows: rowsOf(shownPoints, {x: state.x, y: smallestField, c: colourOf(state), f: state.panels})}), 380);
        const goals = [...new Set(data.sources.map(source => source.goal).filter(isThere))].join(" or ");
        section("smallest", `Smallest ${searchKey}`, goals ? `The smallest value at which the goal holds: ${goals}.` : "", [
            choice("against", optionsOf(variedAxes), state.x, field => { state.x = field; chart.refresh(); }),
            ...(variedAxes.length > 1 ? [colourChoice(state, chart), choice("panels", panelOptions, state.panels, field => {
                state.panels = field;
                chart.refresh();
            })] : [])], chart.figure);
    }

    function addSearch() {
        if (!lookedField || !simulations.length) return;
        const figures = figureFields.filter(field => isDrawable(field, simulations));
        if (!figures.length) return;
        const state = {x: lookedField, y: figures.includes(starvedField) ? starvedField : figures[0], panels: usualPanels(null),
                       colour: allOthers, log: false};
        const chart = new Chart("search", `A figure of every simulation against ${searchKey}`, () => {
            const colour = colourOf(state);
            return {chart: "lines", x: axisTitle(lookedField, true), y: axisTitle(state.y, state.log),
                    colour: {title: colour.title}, facet: {title: state.panels.title}, fields: [state.y],
                    rows: rowsOf(shownSimulations.filter(item => isThere(item.looked)),
                                 {x: lookedField, y: state.y, c: colour, f: state.panels})};
        }, 360);
        section("search", "What the searches saw", "Every simulation that the searches made, not only the smallest that meets " +
            "the goal.", [
            choice("figure", optionsOf(figures), state.y, field => { state.y = field; chart.refresh(); }),
            scaleChoice(state, chart),
            ...(variedAxes.length ? [choice("panels", panelOptions, state.panels, field => {
                state.panels = field;
                chart.refresh();
            })] : [])], chart.figure);
    }

    function addMap() {
        if (ownAxes.length < 2) {
            leftOut.push("Heat map: it takes two axes with more than one value.");
            return;
        }
        if (!offeredFigures.length) {
            leftOut.push("Heat map: no point has figures.");
            return;
        }
        const glitches = starvedField && isVaried(starvedField, points) ? starvedField : null;
        const state = {x: firstNumericAxis || variedAxes[0]};
        const second = ownAxes.filter(field => field !== representative.get(state.x));
        state.y = second.find(field => valuesOf(field, points).length <= mostFields) || second[0];
        state.figure = smallestField || glitches || (rateField && hasValues(rateField, points) ? rateField : offeredFigures[0]);
        const chart = new Chart("map", "Heat map of a figure over two axes", () => {
            if (state.x === state.y) return {words: "Choose two different axes."};
            const crowded = [state.x, state.y].find(field => valuesOf(field, shownPoints).length > mostFields);
            if (crowded) {
                return {words: `${crowded.title} has ${formatValue(valuesOf(crowded, shownPoints).length)} values, too many ` +
                    "for a heat map. Choose another axis, or a figure against it below."};
            }
            return {chart: "heatmap", x: axisTitle(state.x), y: axisTitle(state.y), fields: [state.figure],
                    colour: {title: state.figure.title, percent: state.figure.percent},
                    rows: rowsOf(shownPoints, {x: state.x, y: state.y, c: state.figure,
                                               more: item => ({whole: isWhole(item)})})};
        }, 380);
        section("map", "A figure over two axes", "", [
            choice("figure", optionsOf(offeredFigures), state.figure, field => { state.figure = field; chart.refresh(); }),
            choice("across", optionsOf(variedAxes), state.x, field => { state.x = field; chart.refresh(); }),
            choice("upward", optionsOf(variedAxes), state.y, field => { state.y = field; chart.refresh(); })], chart.figure);
    }

    function addPareto() {
        const all = simulations.length ? simulations : points;
        const isCost = field => field.name === "cost" || (field.meaning || "").startsWith("cost: ");
        const costs = figureFields.filter(field => isCost(field) && isVaried(field, all) && isDrawable(field, all));
        if (!costs.length || !rateField || !hasValues(rateField, all)) {
            leftOut.push("Cost against frame rate: " + (costs.length ? "no point has a frame rate, for which a run needs three frames." :
                "all points cost the same."));
            return;
        }
        const state = {cost: costs[0]};
        const chart = new Chart("pareto", "Cost against frame rate, with the front of the cheapest", () => ({
            chart: "pareto", x: axisTitle(state.cost), y: axisTitle(rateField), fields: [state.cost, rateField],
            rows: rowsOf(simulations.length ? shownSimulations : shownPoints,
                         {x: state.cost, y: rateField, more: item => ({whole: isWhole(item), label: nameOf(item)})})}), 380);
        section("pareto", "Cost against frame rate", simulations.length ? "Every simulation of the searches." : "",
                costs.length > 1 ? [choice("cost", optionsOf(costs), state.cost, field => {
                    state.cost = field;
                    chart.refresh();
                })] : [], chart.figure);
    }

    function addPolicy() {
        const groupings = variedAxes.filter(field => kindOf(points.map(field.get)) === "category" &&
            valuesOf(field, points).length <= 24);
        const figures = ["utilization", "recovered_slots"].map(figureNamed).filter(field => field && hasValues(field, points));
        if (!groupings.length || !figures.length) {
            leftOut.push("Utilization and recovered slots by policy: " + (figures.length
                ? "no axis has names, such as bus.arbitration, for values." : "no point has these figures."));
            return;
        }
        const state = {by: groupings.find(field => field.name === "bus.arbitration") || groupings[0], within: noField};
        const pair = figures.map(figure => new Chart("policy-" + figure.name, `${figure.title} by setting`, () => ({
            chart: "policy", x: axisTitle(state.by), y: axisTitle(figure), fields: [figure],
            colour: {title: state.within.title},
            rows: rowsOf(shownPoints, {x: state.by, y: figure, c: state.within === state.by ? null : state.within})}), 320));
        const refresh = () => pair.forEach(chart => chart.refresh());
        const within = variedAxes.filter(field => valuesOf(field, points).length <= 8);
        section("policy", "Utilization and recovered slots", "", [
            ...(groupings.length > 1 ? [choice("by", optionsOf(groupings), state.by, field => {
                state.by = field;
                refresh();
            })] : []),
            ...(within.length > 1 ? [choice("colour", [{label: "none", value: noField}, ...optionsOf(within)], noField, field => {
                state.within = field;
                refresh();
            })] : [])], element("div", {class: "pair"}, ...pair.map(chart => chart.figure)));
    }

    function addLines() {
        const figures = offeredFigures;
        if (points.length < 2 || !figures.length) {
            leftOut.push("Any figure against any other: " + (figures.length ? "there is only one point." : "no point has figures."));
            return;
        }
        const across = [...variedAxes, ...figures.filter(field => isVaried(field, points))];
        if (!across.length) {
            leftOut.push("Any figure against any other: all points are the same.");
            return;
        }
        const state = {x: firstNumericAxis || across[0], y: rateField && figures.includes(rateField) ? rateField : figures[0],
                       panels: noField, log: false};
        state.colour = usualColour(state);
        const chart = new Chart("lines", "A figure against an axis or another figure", () => {
            const colour = colourOf(state);
            const isAxis = variedAxes.includes(state.x);
            return {chart: isAxis ? "lines" : "scatter", x: axisTitle(state.x), y: axisTitle(state.y, state.log),
                    colour: {title: colour.title}, facet: {title: state.panels.title}, fields: [state.x, state.y],
                    rows: rowsOf(shownPoints, {x: state.x, y: state.y, c: colour, f: state.panels})};
        }, 380);
        section("lines", "Any figure", "", [
            choice("figure", optionsOf(figures), state.y, field => { state.y = field; chart.refresh(); }),
            choice("against", optionsOf(across), state.x, field => { state.x = field; chart.refresh(); }),
            scaleChoice(state, chart),
            colourChoice(state, chart),
            ...(variedAxes.length > 1 ? [choice("panels", panelOptions, noField, field => {
                state.panels = field;
                chart.refresh();
            })] : [])], chart.figure);
    }

    // ----------------------------------------------------------------------------------------------------------- table

    const usualFigures = ["frames_per_second", "frame_cycles", "bottleneck", "starved_pixels", "stalled_cycles", "latency_cycles", "utilization",
                          "page_misses", "recovered_slots", "cost", "buffer_bits", "bus_wires"];
    const table = {sort: null, descending: false, status: "", allFigures: false, rows: mostRowsAtOnce, order: []};

    function tableColumns() {
        const figures = figureFields.filter(field => hasValues(field, points) &&
            (table.allFigures || usualFigures.includes(field.name)));
        const columns = [{key: "point", title: "point", get: item => item.id}, ...axisFields, statusField];
        if (points.some(item => item.reason)) {
            columns.push({key: "reason", title: "reason", get: item => item.reason, words: true});
        }
        if (smallestField) {
            columns.push(smallestField, {key: "runs", title: "simulations", get: item => item.runs});
            if (points.some(item => item.note)) {
                columns.push({key: "note", title: "note", get: item => item.note, words: true});
            }
        }
        return [...columns, ...figures].map(column => ({
            ...column, number: kindOf(points.slice(0, 1000).map(column.get)) === "number"}));
    }

    const textOrder = new Intl.Collator("en", {numeric: true});
    function compared(a, b) {
        if (!isThere(a) || !isThere(b)) return isThere(a) ? -1 : isThere(b) ? 1 : 0;  // missing values come last
        const order = isNumber(a) && isNumber(b) ? a - b : textOrder.compare(String(a), String(b));
        return table.descending ? -order : order;
    }

    function refreshTable() {
        const columns = tableColumns();
        const sort = columns.find(column => column.key === table.sort);
        table.order = shownPoints.filter(item => !table.status || item.status === table.status);
        if (sort) table.order.sort((a, b) => compared(sort.get(a), sort.get(b)));
        const shown = table.order.slice(0, table.rows);
        byId("points").replaceChildren(
            element("thead", {}, element("tr", {}, ...columns.map(column => element("th", {
                scope: "col", class: column.number ? "number" : "", title: column.meaning,
                "aria-sort": column !== sort ? "none" : table.descending ? "descending" : "ascending"},
                element("button", {type: "button", onclick: () => {
                    table.descending = table.sort === column.key && !table.descending;
                    table.sort = column.key;
                    refreshTable();
                }}, column.title + (column !== sort ? "" : table.descending ? " ↓" : " ↑")))))),
            element("tbody", {}, ...shown.map(item => element("tr", {
                tabindex: "0", "data-point": item.index, "aria-label": titleOf(item) + ", " + item.status},
                ...columns.map(column => element("td", {
                    class: column.key === "status" ? "status" + (item.status === "done" ? "" : " bad")
                        : column.words ? "words" : column.number ? "number" : ""},
                    isThere(column.get(item)) ? shownValue(column, column.get(item)) : ""))))));
        const all = points.length;
        byId("table-count").textContent = !table.order.length ? "No point is left by the choices above."
            : (table.order.length === all ? counted(all, "point") : `${formatValue(table.order.length)} of ${counted(all, "point")}`) +
              (shown.length < table.order.length ? `, the first ${formatValue(shown.length)} shown` : "") +
              ". A click or Enter on a row opens the point.";
        const more = byId("more-rows");
        more.hidden = shown.length >= table.order.length;
        more.textContent = `Show ${formatValue(Math.min(1000, table.order.length - shown.length))} more`;
    }

    function buildTable() {
        if (!points.length) {
            byId("table-count").textContent = "There is no point in these results yet.";
            byId("table-scroll").hidden = true;
            return;
        }
        const statuses = [...new Set(points.map(item => item.status))].sort();
        const controls = byId("table-controls");
        if (statuses.length > 1) {
            const counts = status => points.filter(item => item.status === status).length;
            controls.append(choice("status", [{label: "all", value: ""}, ...statuses.map(status =>
                ({label: `${status} (${formatValue(counts(status))})`, value: status}))], "", status => {
                table.status = status;
                table.rows = mostRowsAtOnce;
                refreshTable();
            }));
            controls.lastChild.lastChild.id = "status-filter";
        }
        const all = element("input", {type: "checkbox", id: "all-figures", onchange: () => {
            table.allFigures = all.checked;
            refreshTable();
        }});
        controls.append(element("label", {class: "check"}, all, "every figure"));
        byId("more-rows").addEventListener("click", () => {
            table.rows += 1000;
            refreshTable();
        });
        const open = event => {
            const row = event.target.closest("tr[data-point]");
            if (row) openPanel(points[Number(row.dataset.point)]);
        };
        byId("points").addEventListener("click", open);
        byId("points").addEventListener("keydown", event => {
            if (event.key !== "Enter" || event.target.tagName !== "TR") return;
            event.preventDefault();
            open(event);
        });
        refreshTable();
    }

    // ----------------------------------------------------------------------------------------------------------- panel

    const panel = byId("panel");
    let opened = null;

    function openPanel(item) {
        opened = item;
        byId("panel-title").textContent = titleOf(item);
        const isBad = item.status !== "done";
        const figures = figureFields.filter(field => isThere(field.get(item)))
            .map(field => [field.title, shownValue(field, field.get(item)), field.meaning]);
        const found = item.isPoint && smallestField
            ? [[smallestField.title, isThere(item.smallest) ? item.smallest : "none"], ["simulations", item.runs]] : [];
        const order = item.isPoint ? table.order.indexOf(item) : -1;
        byId("panel-previous").disabled = order <= 0;
        byId("panel-next").disabled = order < 0 || order + 1 >= table.order.length;
        byId("panel-content").replaceChildren(...[
            element("p", {}, element("span", {class: "status" + (isBad ? " bad" : "")}, item.status),
                    item.reason ? ": " + item.reason : ""),
            item.note ? element("p", {}, item.note) : null,
            item.monotonic === 0 ? element("p", {class: "status bad"}, "The goal is not monotonic here.") : null,
            element("h3", {}, "Settings"), pairs([...settingsOf(item), ...found]),
            ...picturesPart(item), ...commandPart(item), reportPart(item),
            ...(figures.length ? [element("h3", {}, "Figures"), pairs(figures)] : []),
        ].filter(part => part !== null));
        tooltip.hidden = true;
        if (!panel.open) panel.showModal();
        panel.scrollTop = 0;
        byId("panel-title").focus({preventScroll: true});
    }

    function buildPanel() {
        byId("panel-close").addEventListener("click", () => panel.close());
        // A click outside the panel's content closes it.
        panel.addEventListener("click", event => { if (event.target === panel) panel.close(); });
        const step = by => {
            const next = table.order[table.order.indexOf(opened) + by];
            if (next) openPanel(next);
        };
        byId("panel-previous").addEventListener("click", () => step(-1));
        byId("panel-next").addEventListener("click", () => step(1));
    }

    // ------------------------------------------------------------------------------------------------------------ page

    function buildHead() {
        const counts = new Map();
        points.forEach(item => counts.set(item.status, (counts.get(item.status) || 0) + 1));
        const parts = [...counts].map(([status, count]) => `${formatValue(count)} ${status}`);
        const of = severalSources ? ` from ${data.sources.length} files` : "";
        byId("summary").textContent = points.length
            ? `${counted(points.length, "point")}${of}: ${parts.join(", ")}.` +
              (searchKey ? ` Each is a search for the smallest ${searchKey}; ${counted(simulations.length, "simulation")}.` : "") +
              (data.condition ? ` Only where ${data.condition}.` : "")
            : "There is no point in these results" + (data.condition ? ` where ${data.condition}.` : " yet.");
        const idle = points.filter(item => figureOf(item, "idle_bus_bits") > 0).length;
        if (idle) {
            byId("remarks").append(element("p", {class: "remark"}, `The buses of ${counted(idle, "point")} are wider than their ` +
                "memory fills, 64 × memory.words_per_cycle bits: narrower ones do the same."));
        }
        for (const field of axisFields) {
            const values = valuesOf(field, points).map(formatValue);
            const shown = values.length > 24 ? [...values.slice(0, 12), "…", ...values.slice(-4), `(${values.length} values)`] : values;
            byId("axes").append(element("dt", {}, field.title), element("dd", {}, shown.join(", ") || "no value"));
        }
        const {reports, pictures, simulations: lost, mebibytes} = data.left_out;
        const absent = [reports ? counted(reports, "report") : "", pictures ? counted(pictures, "picture") : ""].filter(isThere);
        if (absent.length) {
            byId("remarks").append(element("p", {class: "remark"}, `Not in this page: ${absent.join(" and ")} beyond ${mebibytes} ` +
                "MiB. A page of fewer points (--where) or with a larger --embed-mib has them."));
        }
        if (lost) {
            byId("remarks").append(element("p", {class: "remark"}, `Not in this page: ${counted(lost, "simulation")} of the ` +
                "searches; metabuffer export --runs writes all."));
        }
    }

    buildHead();
    buildFilters();
    buildPanel();
    if (points.length) {
        for (const add of [addSmallest, addMap, addPareto, addPolicy, addSearch, addLines]) add();
    }
    buildTable();
    byId("left-out").hidden = !leftOut.length;
    leftOut.forEach(words => byId("left-out").querySelector("ul").append(element("li", {}, words)));
    charts.forEach(chart => chart.refresh());
    darkness.addEventListener("change", () => charts.forEach(chart => chart.refresh()));
    let pageWidth = window.innerWidth;
    let resizing = 0;
    window.addEventListener("resize", () => {
        if (window.innerWidth === pageWidth) return;  // a phone's address bar comes and goes
        pageWidth = window.innerWidth;
        clearTimeout(resizing);
        resizing = setTimeout(() => charts.forEach(chart => chart.refresh()), 150);
    });
})();
