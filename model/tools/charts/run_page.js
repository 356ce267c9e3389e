// The page about one run: connects the displays, the time line and the figures.
(() => {
    "use strict";
    const run = metabufferRun, {data, machine, report} = run;
    const {element, percent, shellWord, copyButton, saveButton, busesOf} = metabufferElements;
    const {Wall, rendererColour} = metabufferWall;
    const {TimeLine} = metabufferTime;
    const byId = id => document.getElementById(id);
    const number = value => typeof value === "number" ? value.toLocaleString("en", {maximumFractionDigits: 2}) : String(value);
    const counted = (count, thing) => `${number(count)} ${thing}${count === 1 ? "" : "s"}`;
    const nameOf = renderer => machine.renderers[renderer].name;
    const hexOf = colour => "#" + colour.toString(16).padStart(6, "0");
    const microseconds = clock => (clock * machine.period_ps / 1e6).toLocaleString("en", {maximumFractionDigits: 3}) + " µs";
    const framesPerSecondWhilePlaying = 5;
    const widestWindow = 20_000;    // clocks; in a wider view the waveform has only clocks around the chosen one
    const aroundClock = 1000;

    let frameAt = 0;                // in data.frames
    let hovered = null, pinned = null;
    let playing = 0;

    // ------------------------------------------------------------------------------------------------------------- head

    function buildHead() {
        const rates = report.rates || {};
        byId("summary").textContent = `${counted(machine.renderers.length, "renderer")}, ${counted(run.displays, "display")} of ` +
            `${machine.width}x${machine.height}, ${counted(report.frames.length, "frame")}, ${counted(report.core_cycles, "core clock")} ` +
            `at ${number(machine.core_mhz)} MHz.`;
        const answers = [];
        if (report.bottleneck) {
            const {resource, share, pixels_starve: starve, worst_renderer: worst} = report.bottleneck;
            answers.push(["bottleneck", starve ? `${resource}: pixels starve; the bus of ${worst} works ${percent(share)} of the raster's clocks`
                : `${resource}, for ${percent(share)} of the clocks`]);
        }
        if (typeof rates.frames_per_second === "number") {
            answers.push(["frames a second", `${number(rates.frames_per_second)} held; displays refresh ${number(rates.refresh_hz)} times`]);
        }
        const {starved_pixels: starved, wrong_pixels: wrong, stalled_cycles: stalled} = report.totals;
        answers.push(["starved", starved ? `${counted(starved, "raster pixel")}` +
            (typeof wrong === "number" ? `; ${counted(wrong, "shown pixel")} wrong` : "") : "nothing"]);
        if (stalled) answers.push(["stalled", counted(stalled, "clock")]);
        answers.push(["buffers", `${number(machine.buffer_pixels)} pixels each; ` + (data.safe_buffer_pixels === null
            ? "no bound is proved" : `proved never to starve: ${number(data.safe_buffer_pixels)}`)]);
        for (const [title, text] of answers) {
            byId("answers").append(element("dt", {}, title), element("dd", {class: title === "starved" && starved ? "bad" : null}, text));
        }
        const remarks = [...data.remarks];
        if (data.advice.length) {
            remarks.push("What would keep pixels from starving, each by itself, as runs have shown: " + data.advice.join("; ") + ".");
        }
        for (const finding of report.watchdog || []) remarks.push("Watchdog: " + finding);
        const corrected = Object.keys(machine.corrections).map(display => Number(display) + 1).sort((a, b) => a - b);
        if (corrected.length) {
            remarks.push(`The pictures are as the displays show them: displays.correction corrects the colours of display ` +
                `${corrected.join(", ")}. What renderers contribute, and what leaves the pipeline, is not corrected.`);
        }
        if (data.stride > 1) {
            remarks.push(`Pictures of every ${data.stride}th frame are in the page; --embed-mib with more takes more of them.`);
        }
        if (data.images_left_out) {
            remarks.push(`${counted(data.images_left_out, "image")} of renderers ${data.images_left_out === 1 ? "is" : "are"} not in the ` +
                "page, so who won is not known in their frames; --embed-mib with more takes more of them.");
        }
        const cut = (tracks, what, instead) => {
            const lost = tracks.reduce((sum, track) => sum + track.left_out, 0);
            if (lost) remarks.push(`Not in the page: ${number(lost)} ${what}; ${instead}. A run of fewer --frames has all.`);
        };
        cut(run.record.buses, "bursts, waits and other spans of buses", "after the last one there, sums over stretches of clocks are drawn");
        cut(run.record.levels, "levels of buffers", "after the last one there, the least and the most in stretches of clocks are drawn");
        cut([run.record.starved], "runs of starved pixels", "the later ones, which are counted but not shown");
        cut(run.record.stalls, "stalls of columns", "the later ones, so that clocks of pixels after them are too early");
        cut(run.record.links, "frames of links", "the later ones");
        byId("remarks").append(...remarks.map(text => element("p", {class: "remark"}, text)));
    }

    // ------------------------------------------------------------------------------------------------------------- wall

    const wall = new Wall(byId("wall"), {
        hover: pixel => { hovered = pixel; showPixel(); },
        pixel: pixel => { pinned = pixel; hovered = null; showPixel(); if (pixel) goToClockOf(pixel); },
        open: pixel => { goToClockOf(pixel, true); byId("time").focus(); },
    });
    const entry = () => data.frames[frameAt];

    function showFrame(index) {
        frameAt = Math.max(0, Math.min(data.frames.length - 1, index));
        const {frame} = entry(), record = report.frames[frame];
        byId("frame").value = frameAt;
        byId("frame-name").textContent = `frame ${frame} of 0 to ${report.frames.length - 1}`;
        const sum = list => Array.isArray(list) ? list.reduce((total, count) => total + count, 0) : 0;
        byId("wall-note").textContent = (record ? `Frame ${frame}: composited from clock ${number(record.start_cycle)} to ` +
            `${number(record.end_cycle)}, on the displays from ${number(record.swap_cycle)}; ` +
            `${counted(sum(record.starved_pixels), "raster pixel")} starved, ${counted(sum(record.wrong_pixels), "shown pixel")} wrong. ` : "") +
            "Wheel and drag zoom and move; a click, or the arrow keys, choose a pixel and show its clock below.";
        wall.beams = [];
        return wall.show(entry()).then(showPixel);
    }
    const indexOfFrame = frame => {
        const index = data.frames.findIndex(one => one.frame === frame);
        return index >= 0 ? index : null;
    };

    function showPixel() {
        const box = byId("pixel"), chosen = hovered || pinned;
        if (!chosen) {
            box.replaceChildren(element("p", {class: "what"}, "The pixel under the mouse is explained here."));
            return;
        }
        const {display, x, y} = chosen, frame = entry().frame;
        const clocks = [0, run.renderers - 1].map(renderer => run.clockOf(frame, display, renderer, x, y));
        const rows = [["display", display + 1], [machine.supersample > 1 ? "raster pixel" : "pixel", `${x}, ${y}`]];
        if (clocks[0] !== null) {
            rows.push(["composited at clock", clocks[0] === clocks[1] ? number(clocks[0])
                : `${number(clocks[0])} in the top composer, ${number(clocks[1])} in the bottom one`]);
        }
        const parts = [element("table", {}, element("tbody", {}, ...rows.map(([title, value]) =>
            element("tr", {}, element("th", {scope: "row"}, title), element("td", {}, String(value))))))];
        if (!entry().contributions || !wall.layers) {
            parts.push(element("p", {class: "what"}, wall.layers ? "What renderers contributed to this frame is not known." : "…"));
            box.replaceChildren(...parts);
            return;
        }
        const {locals, pixel, isWhole} = run.rasterPixel(entry(), display, x, y);
        const winner = pixel.winner;
        const lines = locals.map(local => {
            const won = isWhole && local.renderer === winner;
            const value = local.colour === undefined ? "not in the page" : `${hexOf(local.colour)} A ${local.alpha} Z ${local.z}`;
            return element("tr", {class: won ? "won" : "lost", "data-renderer": local.renderer + 1},
                element("th", {scope: "row"}, element("i", {style: "background:" + rendererColour(local.renderer)}), nameOf(local.renderer)),
                element("td", {}, local.colour === undefined ? null : element("i", {style: "background:" + hexOf(local.colour)}),
                        `${value}${local.starved ? ", starved" : ""}`,
                        element("div", {class: "what"}, `pixel ${local.sourceX}, ${local.sourceY} of its image` +
                            `${local.isMixed ? ", mixed with those around it" : ""}; clock ` +
                            number(run.clockOf(frame, display, local.renderer, x, y) ?? "unknown"))));
        });
        parts.push(element("p", {id: "winner"}, !isWhole ? "Who won is not known." : winner < 0 ? "The background is shown."
            : `${nameOf(winner)} wins.`));
        if (isWhole) {
            parts.push(element("p", {}, element("i", {style: "background:" + hexOf(pixel.colour)}),
                `leaves the pipeline: ${hexOf(pixel.colour)} A ${pixel.alpha} Z ${pixel.z}`));
        }
        const shown = machine.corrections[display] === undefined ? null
            : run.shownPixel(entry(), display, Math.floor(x / machine.supersample), Math.floor(y / machine.supersample));
        if (shown !== null) {
            parts.push(element("p", {id: "corrected"}, element("i", {style: "background:" + hexOf(shown)}),
                `the display shows: ${hexOf(shown)}, corrected by its table`));
        }
        parts.push(lines.length ? element("table", {id: "locals"}, element("tbody", {}, ...lines))
            : element("p", {class: "what"}, "No renderer covers this pixel."));
        box.replaceChildren(...parts);
    }

    function goToClockOf({display, x, y}, zoomIn) {
        const local = entry().contributions ? run.rasterPixel(entry(), display, x, y).locals.find(one => one.starved) : null;
        const clock = run.clockOf(entry().frame, display, local ? local.renderer : 0, x, y);
        if (clock === null) return;
        showGroup(display);
        if (zoomIn) time.look(clock - 200, clock + 200);
        chooseClock(clock, true);
    }

    function buildWallControls() {
        const frames = data.frames.length;
        const slider = element("input", {type: "range", id: "frame", min: 0, max: Math.max(0, frames - 1), value: 0, step: 1,
                                         oninput: () => { stop(); showFrame(Number(slider.value)); }});
        const play = element("button", {type: "button", id: "play", onclick: () => playing ? stop() : start()}, "Play");
        const button = (id, title, act) => element("button", {type: "button", id, onclick: act}, title);
        const view = element("select", {id: "view", onchange: () => wall.show(entry(), view.value).then(showPixel)},
            element("option", {value: "picture"}, "what is shown"), element("option", {value: "winner"}, "who won each pixel"));
        const box = (id, title, mark) => {
            const input = element("input", {type: "checkbox", id, checked: true,
                                            onchange: () => { wall.marks[mark] = input.checked; wall.draw(); }});
            return element("label", {class: "check"}, input, title);
        };
        const glitches = run.displays && report.totals.starved_pixels > 0;
        byId("wall-controls").append(
            element("label", {class: "wide"}, element("span", {id: "frame-name"}), slider),
            button("previous-frame", "Previous", () => { stop(); showFrame(frameAt - 1); }), play,
            button("next-frame", "Next", () => { stop(); showFrame(frameAt + 1); }),
            element("label", {}, "view", view),
            ...(glitches ? [box("mark-starved", "starved", "starved"), box("mark-wrong", "wrong", "wrong"),
                            button("previous-glitch", "Glitch before", () => stepGlitch(-1)),
                            button("next-glitch", "Next glitch", () => stepGlitch(1))] : []),
            button("zoom-wall-in", "+", () => wall.zoomBy(1.5)), button("zoom-wall-out", "−", () => wall.zoomBy(1 / 1.5)),
            button("whole-wall", "Whole wall", () => wall.zoomBy(1e-9)));
        const key = machine.renderers.slice(0, 24).map((renderer, n) =>
            element("span", {}, element("i", {style: "background:" + rendererColour(n)}), renderer.name));
        const more = machine.renderers.length - key.length;
        byId("wall-note").before(element("div", {class: "key", id: "wall-key"}, ...key,
            more > 0 ? element("span", {}, `and ${more} more`) : null,
            ...(glitches ? [element("span", {}, element("i", {style: "background:#ffd400"}), "starved, hidden by another"),
                            element("span", {}, element("i", {style: "background:#ff1f5a"}), "wrong")] : [])));
    }
    function start() {
        if (frameAt + 1 >= data.frames.length) showFrame(0);
        byId("play").textContent = "Stop";
        // The next frame waits until this one is drawn, so that a frame that takes long is shown as well.
        const next = () => {
            if (frameAt + 1 >= data.frames.length) return stop();
            const due = performance.now() + 1000 / framesPerSecondWhilePlaying, mine = playing;
            return showFrame(frameAt + 1).then(() => {
                if (playing === mine) playing = setTimeout(next, due - performance.now());
            });
        };
        playing = setTimeout(next, 1000 / framesPerSecondWhilePlaying);
    }
    function stop() {
        clearTimeout(playing);
        playing = 0;
        byId("play").textContent = "Play";
    }

    // ------------------------------------------------------------------------------------------------------------- time

    const tooltip = byId("tooltip");
    const time = new TimeLine(byId("time"), {
        clock: clock => chooseClock(clock),
        glitch: glitch => showGlitch(glitch),
        view: () => showClock(),
        hover: (found, event) => {
            tooltip.hidden = !found;
            if (!found) return;
            tooltip.replaceChildren(element("b", {}, `${found.row.title}, clock ${number(found.clock)}`), found.text);
            tooltip.style.left = Math.min(window.innerWidth - tooltip.offsetWidth - 12, event.clientX + 14) + "px";
            tooltip.style.top = Math.min(window.innerHeight - tooltip.offsetHeight - 12, event.clientY + 16) + "px";
        },
    });

    /// Shows a clock on the time line, and on the displays what they composite in it. `fromWall`: its frame is shown
    /// already.
    function chooseClock(clock, fromWall) {
        time.setClock(clock);
        const beams = [...Array(run.displays).keys()].map(display => [display, run.beamAt(time.clock, display)])
            .filter(([, beam]) => beam);
        if (!fromWall && beams.length) {
            const index = indexOfFrame(beams[0][1].frame);
            if (index !== null && index !== frameAt) showFrame(index);
        }
        wall.beams = beams.filter(([, beam]) => beam.frame === entry().frame).map(([display, {x, y}]) => ({display, x, y}));
        wall.draw();
        showClock();
    }
    function showGroup(display) {
        if (time.group.kind !== "display" || time.group.number === display) return;
        byId("group").value = "display " + display;
        time.setGroup({kind: "display", number: display});
    }
    let shownGlitch = null;
    function showGlitch(glitch) {
        stop();
        shownGlitch = glitch;
        const index = indexOfFrame(glitch.frame);
        if (index !== null && index !== frameAt) showFrame(index);
        showGroup(glitch.display);
        if (glitch.clock < time.from || glitch.clock > time.to || time.to - time.from > 40 * run.rasterWidth) {
            time.look(glitch.clock - 4 * run.rasterWidth, glitch.clock + 4 * run.rasterWidth);
        }
        const shown = index !== null;
        pinned = shown ? {display: glitch.display, x: glitch.first, y: glitch.y} : null;
        hovered = null;
        wall.chosen = pinned;
        wall.reveal();
        chooseClock(glitch.clock, true);
        showPixel();
    }
    /// Shows the next (`direction` 1) or previous (-1) glitch, from the chosen clock. Glitches of one clock are in the
    /// order of displays.
    function stepGlitch(direction) {
        let best = null;
        const now = time.clock === null ? (direction > 0 ? -1 : run.cycles) : time.clock;
        const at = shownGlitch && shownGlitch.clock === time.clock ? shownGlitch : null;
        const displays = [...Array(run.displays).keys()];
        for (const display of direction > 0 ? displays : displays.reverse()) {
            const glitches = run.glitchesOf(display), before = at && (display - at.display) * direction > 0 ? direction : 0;
            // Ends at the first glitch after the clock, or at it if those at the clock come next.
            let low = 0, high = glitches.length;
            while (low < high) {
                const middle = (low + high) >> 1;
                if (glitches[middle].clock + before <= now - (direction < 0 ? 1 : 0)) low = middle + 1; else high = middle;
            }
            let index = direction > 0 ? low : low - 1;
            if (at && display === at.display) index = glitches.indexOf(at) + direction;
            const found = glitches[index];
            if (found && (!best || (found.clock - best.clock) * direction < 0)) best = found;
        }
        if (best) showGlitch(best);
    }

    /// Writes to a folder of its own: the scenario's may be the one that the page was made from, and must keep its
    /// results.
    function waveformCommand() {
        const whole = time.to - time.from <= widestWindow && (time.clock === null || (time.clock >= time.from && time.clock < time.to));
        const first = whole ? Math.max(0, Math.floor(time.from)) : Math.max(0, (time.clock ?? 0) - aroundClock);
        const last = whole ? Math.min(run.cycles - 1, Math.ceil(time.to)) : (time.clock ?? 0) + aroundClock;
        return [data.command.map(shellWord).join(" "), "    --no-images --out out/waveform --trace out/waveform/trace.vcd",
                `    --trace-window cycles:${first}-${last}`].join(" \\\n");
    }
    function showClock() {
        const box = byId("clock"), parts = [];
        if (time.clock === null) {
            parts.push(element("p", {class: "what"}, "A click chooses a clock; wheel and drag zoom and move, as do the arrow keys, + and " +
                "−; 0 shows all. A click on a yellow mark shows the starved pixels on the displays."));
        } else {
            const lines = time.rows.filter(row => row.describe).slice(0, 400).map(row => [row.title, row.describe(time.clock)]);
            parts.push(element("p", {}, element("b", {}, `Clock ${number(time.clock)}`), `, ${microseconds(time.clock)}`),
                element("details", {id: "clock-details"}, element("summary", {}, "what each row does in it"),
                    element("table", {}, element("tbody", {}, ...lines.map(([title, text]) =>
                        element("tr", {}, element("th", {scope: "row"}, title), element("td", {}, text)))))));
            if (box.querySelector("details[open]")) parts[1].open = true;
        }
        if (time.clock !== null || time.to - time.from <= widestWindow) {
            parts.push(element("p", {}, "Its waveform, for GTKWave:"), element("pre", {id: "command"}, waveformCommand()),
                       element("p", {}, copyButton(waveformCommand, () => byId("command"))));
        }
        box.replaceChildren(...parts);
    }
    function buildTimeControls() {
        const button = (id, title, act) => element("button", {type: "button", id, onclick: act}, title);
        const groups = [...Array(run.displays).keys()].map(n => ["display " + n, `of display ${n + 1}`])
            .concat(machine.renderers.map((renderer, n) => ["renderer " + n, `of ${renderer.name}`]));
        const group = element("select", {id: "group", onchange: () => {
            const [kind, index] = group.value.split(" ");
            time.setGroup({kind, number: Number(index)});
            showClock();
        }}, ...groups.map(([value, title]) => element("option", {value}, title)));
        byId("time-controls").append(
            button("zoom-in", "Zoom in", () => time.zoomBy(0.5, time.middle())), button("zoom-out", "Zoom out", () => time.zoomBy(2, time.middle())),
            button("whole-run", "Whole run", () => time.look(0, run.cycles)),
            button("this-frame", "This frame", () => {
                const spans = run.record.composited[entry().frame];
                if (!spans) return;
                const first = Math.min(...spans.map(([start]) => start)), last = Math.max(...spans.map(([, end]) => end));
                time.look(first - 0.03 * (last - first), last + 0.03 * (last - first));
            }),
            element("label", {}, "buffers", group));
        const used = report.totals.bus || {};
        byId("time-key").append(...run.uses.map(({counter, name, colour}) => used[counter]
            ? element("span", {}, element("i", {style: "background:" + colour}), name) : null).filter(part => part),
            element("span", {}, element("i", {style: "background:#2fc79a"}), "slots recovered"),
            ...(report.totals.starved_pixels ? [element("span", {}, element("i", {style: "background:#ffd400"}), "starved pixels")] : []),
            ...(data.safe_buffer_pixels !== null && data.safe_buffer_pixels < machine.buffer_pixels
                ? [element("span", {}, element("i", {style: "background:#2fa36b"}), "depth that is proved to be enough")] : []));
    }

    // ---------------------------------------------------------------------------------------------------------- figures

    function listOf(counters, owners, name) {
        const most = 400;
        const head = element("tr", {}, element("th", {}, name), ...counters.map(counter =>
            element("th", {class: "number", title: counter.meaning}, counter.name.replaceAll("_", " "))));
        const rows = owners.slice(0, most).map(([title, values]) => element("tr", {}, element("th", {scope: "row"}, title),
            ...counters.map(counter => element("td", {class: "number"}, number(values[counter.name] ?? "–")))));
        return [element("div", {class: "scroll"}, element("table", {}, element("thead", {}, head), element("tbody", {}, ...rows))),
                owners.length > most ? element("p", {class: "what"}, `and ${number(owners.length - most)} more, in report.json`) : null];
    }
    /// All single figures of a part of the report, named by their path; items of lists are named by their indices.
    function flat(part, prefix = "") {
        const figures = {};
        for (const [key, value] of Object.entries(part || {})) {
            if (value !== null && typeof value === "object") Object.assign(figures, flat(value, `${prefix}${key} `));
            else if (value !== null) figures[prefix + key.replaceAll("_", " ")] = value;
        }
        return figures;
    }
    const pairsOf = figures => element("table", {}, element("tbody", {}, ...Object.entries(figures).map(([title, value]) =>
        element("tr", {}, element("th", {scope: "row"}, title), element("td", {class: "number"}, number(value))))));
    function buildFigures() {
        byId("buses-section").append(...busesOf(report).filter(part => part));
        const composers = report.composers.map(one => [`${nameOf(one.renderer - 1)}, display ${one.display}`, one]);
        const fold = (title, content, open) => element("details", {open}, element("summary", {}, title), ...content.filter(part => part));
        byId("counters").append(
            fold("Summary, as metabuffer run prints it", [element("pre", {}, data.summary)], true),
            fold("Rates, bottleneck and cost", [pairsOf({...flat(report.rates), ...flat(report.bottleneck), ...flat(report.cost)})]),
            fold("Buses", listOf(data.counters.buses, report.renderers.map(one => [one.name, one.bus]), "renderer")),
            fold("Links", listOf(data.counters.renderers, report.renderers.map(one => [one.name, one]), "renderer")),
            fold("Composers", listOf(data.counters.composers, composers, "composer")),
            fold("Displays", listOf(data.counters.displays, report.displays.map((one, n) => [`display ${n + 1}`, one]), "display")),
            element("p", {}, saveButton("Save report.json", "report.json", JSON.stringify(report, null, 2))));
    }

    // -------------------------------------------------------------------------------------------------------------- go

    buildHead();
    buildWallControls();
    buildTimeControls();
    buildFigures();
    showPixel();
    showClock();
    run.ready.then(async () => {
        time.draw();
        if (data.frames.length) await showFrame(0);
        document.documentElement.dataset.ready = "yes";
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { wall.draw(); time.draw(); });
})();
