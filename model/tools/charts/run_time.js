// What links, buses, buffers and displays do when, from the whole run to single clocks.
const metabufferTime = (() => {
    "use strict";
    const {sizeCanvas} = metabufferElements;
    const run = metabufferRun, {machine, record} = run;
    const labelWidth = 138, axisHeight = 26, mostHeight = 620, leastClocks = 12;
    const clip = (value, least, most) => Math.min(most, Math.max(least, value));

    class TimeLine {
        /// on.clock(clock): the user chose a clock. on.glitch(glitch): the user chose a run of starved pixels.
        constructor(canvas, on) {
            this.canvas = canvas;
            this.on = on;
            this.from = 0;
            this.to = run.cycles;
            this.clock = null;
            this.scroll = 0;
            this.group = {kind: "display", number: 0};
            this.used = new Float64Array(run.uses.length);
            this.before = new Float64Array(run.uses.length);
            this.layOut();
            this.listen();
            new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
            this.resize();
        }

        layOut() {
            const rows = [];
            const add = (label, height, paint, describe, title) => rows.push({label, height, paint, describe, title: title || label});
            const names = machine.renderers.map(renderer => renderer.name);
            names.forEach((name, r) => add("link " + name, 15, (...area) => this.paintLink(r, ...area), clock => this.describeLink(r, clock)));
            names.forEach((name, r) => add("bus " + name, 26, (...area) => this.paintBus(r, ...area), clock => this.describeBus(r, clock)));
            for (let d = 0; d < run.displays; ++d) {
                add(`display ${d + 1}`, 20, (...area) => this.paintDisplay(d, ...area), clock => this.describeDisplay(d, clock));
            }
            add("on the displays", 15, (...area) => this.paintShown(...area), clock => this.describeShown(clock));
            const buffers = this.group.kind === "display" ? names.map((name, r) => [r, this.group.number])
                : [...Array(run.displays).keys()].map(d => [this.group.number, d]);
            for (const [r, d] of buffers) {
                add(`buffer ${names[r]} ${d + 1}`, 34, (...area) => this.paintLevel(r, d, ...area), clock => this.describeLevel(r, d, clock),
                    `composer of ${names[r]} and display ${d + 1}`);
            }
            let top = 0;
            for (const row of rows) {
                row.top = top;
                top += row.height + 3;
            }
            this.rows = rows;
            this.rowsHeight = top;
        }
        setGroup(group) {
            this.group = group;
            this.layOut();
            this.width = 0;
            this.resize();
        }
        resize() {
            const width = Math.max(320, Math.floor(this.canvas.parentElement.clientWidth));
            const height = Math.min(mostHeight, this.rowsHeight + axisHeight);
            if (!sizeCanvas(this, width, height)) return;
            this.scroll = clip(this.scroll, 0, this.mostScroll);
            this.draw();
        }
        get mostScroll() { return Math.max(0, this.rowsHeight + axisHeight - this.height); }
        get plotWidth() { return this.width - labelWidth; }
        get clocksPerPixel() { return (this.to - this.from) / this.plotWidth; }
        xOf(clock) { return labelWidth + (clock - this.from) / this.clocksPerPixel; }
        clockAt(x) { return this.from + (x - labelWidth) * this.clocksPerPixel; }

        look(from, to) {
            let length = clip(to - from, leastClocks, Math.max(leastClocks, run.cycles));
            this.from = clip(from, 0, Math.max(0, run.cycles - length));
            this.to = this.from + length;
            this.draw();
            this.on.view(this.from, this.to);
        }
        zoomBy(factor, clock = (this.from + this.to) / 2) {
            const length = Math.max(leastClocks, (this.to - this.from) * factor), share = (clock - this.from) / (this.to - this.from);
            this.look(clock - share * length, clock + (1 - share) * length);
        }
        moveBy(share) {
            const by = (this.to - this.from) * share;
            this.look(this.from + by, this.to + by);
        }
        setClock(clock) {
            this.clock = clip(Math.floor(clock), 0, run.cycles - 1);
            if (this.clock < this.from || this.clock >= this.to) {
                const half = (this.to - this.from) / 2;
                this.look(this.clock - half, this.clock + half);
            }
            this.draw();
        }

        draw() {
            if (this.waiting) return;
            this.waiting = true;
            requestAnimationFrame(() => { this.waiting = false; this.paint(); });
        }
        paint() {
            const context = this.context = this.canvas.getContext("2d");
            const style = getComputedStyle(document.documentElement);
            this.ink = Object.fromEntries(["text", "quiet", "line", "surface", "background", "accent", "bad"].map(name =>
                [name, style.getPropertyValue("--" + name).trim()]));
            context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
            context.clearRect(0, 0, this.width, this.height);
            context.font = `11px ${style.fontFamily}`;
            context.textBaseline = "middle";
            context.save();
            context.beginPath();
            context.rect(0, axisHeight, this.width, this.height - axisHeight);
            context.clip();
            for (const row of this.rows) {
                const top = axisHeight + row.top - this.scroll;
                if (top + row.height < axisHeight || top > this.height) continue;
                context.fillStyle = this.ink.surface;
                context.fillRect(labelWidth, top, this.plotWidth, row.height);
                context.fillStyle = this.ink.text;
                context.fillText(this.fitted(row.label, labelWidth - 10), 2, top + row.height / 2);
                context.save();
                context.beginPath();
                context.rect(labelWidth, top, this.plotWidth, row.height);
                context.clip();
                row.paint(top, row.height);
                context.restore();
            }
            context.restore();
            this.paintAxis();
            if (this.clock !== null) {
                const left = this.xOf(this.clock), width = Math.max(1.5, 1 / this.clocksPerPixel);
                if (left >= labelWidth - width && left <= this.width) {
                    context.fillStyle = "#ff00ff";
                    context.globalAlpha = width > 3 ? 0.3 : 0.9;
                    context.fillRect(Math.max(labelWidth, left), axisHeight - 6, width, this.height);
                    context.globalAlpha = 1;
                }
            }
        }
        fitted(text, width) {
            if (this.context.measureText(text).width <= width) return text;
            let length = text.length;
            while (length > 1 && this.context.measureText(text.slice(0, length) + "…").width > width) --length;
            return text.slice(0, length) + "…";
        }
        paintAxis() {
            const context = this.context, wanted = (this.to - this.from) * 90 / this.plotWidth;
            const power = 10 ** Math.floor(Math.log10(Math.max(1, wanted)));
            const step = [1, 2, 5, 10].map(n => n * power).find(n => n >= wanted) || 10 * power;
            context.fillStyle = this.ink.quiet;
            context.strokeStyle = this.ink.line;
            context.beginPath();
            for (let clock = Math.ceil(this.from / step) * step; clock <= this.to; clock += step) {
                const x = Math.round(this.xOf(clock)) + 0.5;
                context.moveTo(x, axisHeight - 6);
                context.lineTo(x, axisHeight);
                const text = clock.toLocaleString("en");
                if (x + context.measureText(text).width / 2 < this.width) {
                    context.textAlign = "center";
                    context.fillText(text, Math.max(x, labelWidth + context.measureText(text).width / 2), 9);
                }
            }
            context.stroke();
            context.textAlign = "left";
            context.fillText("core clock", 2, 9);
        }

        /// Draws a span with the first of `texts` that fits into it.
        span(first, end, top, height, colour, texts, light) {
            const left = this.xOf(first), right = this.xOf(end), context = this.context;
            if (right < labelWidth || left > this.width) return;
            const width = Math.max(right - left, 0.6);
            context.fillStyle = colour;
            context.fillRect(left, top, width - (width > 4 ? 0.8 : 0), height);
            if (!texts || width < 10 || height < 12) return;
            const from = Math.max(left, labelWidth) + 3, room = Math.min(right, this.width) - from - 3;
            const text = texts.find(one => context.measureText(one).width <= room);
            if (text === undefined) return;
            context.fillStyle = light ? "#10161c" : "#ffffff";
            context.fillText(text, from, top + height / 2 + 0.5);
        }

        // ------------------------------------------------------------------------------------------------------- links

        paintLink(renderer, top, height) {
            for (const [first, last, kind, pair, taken] of record.links[renderer].frames) {
                if (last < this.from || first > this.to) continue;
                const colour = !taken ? "#c0392b" : kind === "colour" ? "#3b7ea1" : "#6f6a9c";
                this.span(first, last + 1, top, height, colour, pair === null ? [kind] : [`pair ${pair} ${kind}`, `${pair} ${kind}`, String(pair)]);
            }
        }
        describeLink(renderer, clock) {
            const found = record.links[renderer].frames.find(([first, last]) => first <= clock && clock <= last);
            if (!found) return "between frames";
            const [first, last, kind, pair, taken, cause] = found;
            return (pair === null ? "a frame whose control scanline cannot be read" : `${kind} frame of pair ${pair}`) +
                (taken ? "" : cause ? `, rejected: ${cause}` : ", passed over") + `, ${run.clocksFromTo(first, last)}`;
        }

        // ------------------------------------------------------------------------------------------------------- buses

        paintBus(renderer, top, height) {
            const track = run.buses[renderer].get(() => this.draw());
            if (!track) return;
            const first = Math.max(0, run.lastAtOrBefore(track.starts, this.from));
            const last = run.lastAtOrBefore(track.starts, this.to);
            if (this.to <= track.known && last - first < this.plotWidth / 2) {
                for (let n = first; n <= last; ++n) {
                    const kind = track.kinds[n], {name, colour, isLight} = run.uses[kind];
                    const texts = kind === run.pixelUse
                        ? [`${track.pixels[n]} pixels for display ${track.numbers[n]}`, `display ${track.numbers[n]}`, String(track.numbers[n])]
                        : kind === run.tableUse ? [`table of frame ${track.numbers[n]}`, name] : [name];
                    this.span(track.starts[n], track.starts[n] + track.lengths[n], top, height, colour, texts, isLight);
                    if (kind === run.pixelUse && track.recovered[n]) {
                        this.span(track.starts[n], track.starts[n] + track.lengths[n], top + height - 4, 4, "#2fc79a");
                    }
                }
                return;
            }
            // One column for each pixel of the screen: the shares of its clocks, by use of the bus.
            let [before, used] = [this.before, this.used];
            track.before(this.from, before);
            const context = this.context, step = 1 / this.ratio;
            for (let x = 0; x < this.plotWidth; x += step) {
                track.before(this.clockAt(labelWidth + x + step), used);
                let y = top + height;
                for (let use = 0; use < run.uses.length; ++use) {
                    const share = (used[use] - before[use]) / (this.clocksPerPixel * step);
                    if (share <= 0.002) continue;
                    context.fillStyle = run.uses[use].colour;
                    context.fillRect(labelWidth + x, y - share * height, step, share * height);
                    y -= share * height;
                }
                [before, used] = [used, before];
            }
        }
        describeBus(renderer, clock) {
            const track = run.buses[renderer].get(() => this.draw());
            if (!track) return "…";
            if (clock > track.known) return "beyond the spans that are in the page";
            const n = track.at(clock);
            return n < 0 ? "nothing to send" : track.describe(n);
        }

        // ---------------------------------------------------------------------------------------------------- displays

        paintDisplay(display, top, height) {
            const composited = record.composited;
            for (let frame = 0; frame < composited.length; ++frame) {
                const [first, last] = composited[frame][display];
                if (last < this.from || first > this.to || last < first) continue;
                this.span(first, last + 1, top, height, "#3d7d5a", [`composites frame ${frame}`, `frame ${frame}`, String(frame)]);
                let drawn = -1;
                for (const [start, length] of run.stalls[display].get(frame) || []) {
                    if (start + length < this.from || start > this.to) continue;
                    const right = this.xOf(start + length);
                    if (right < drawn + 0.4) continue;      // too thin to be visible next to the one before
                    drawn = right;
                    this.span(start, start + length, top, height, "#c0392b", ["stall"]);
                }
            }
            const glitches = run.glitchesOf(display);
            let drawn = -1;
            for (let n = this.firstGlitch(glitches, this.from); n < glitches.length && glitches[n].clock <= this.to; ++n) {
                const left = this.xOf(glitches[n].clock), right = this.xOf(glitches[n].end + 1);
                if (right < drawn + 0.4) continue;
                drawn = right;
                this.context.fillStyle = "#ffd400";
                this.context.fillRect(left, top, Math.max(1, right - left), height / 2);
            }
        }
        /// The first glitch that can reach a clock: glitches are sorted by first clock and at most a raster row long.
        firstGlitch(glitches, clock) {
            let low = 0, high = glitches.length;
            while (low < high) {
                const middle = (low + high) >> 1;
                if (glitches[middle].clock < clock - run.rasterWidth) low = middle + 1; else high = middle;
            }
            return low;
        }
        /// The starved run of a display nearest to a clock, at most 4 pixels of the screen away, or null.
        glitchNear(display, clock) {
            const glitches = run.glitchesOf(display), reach = 4 * this.clocksPerPixel;
            let best = null, distance = reach;
            for (let n = this.firstGlitch(glitches, clock - reach); n < glitches.length; ++n) {
                if (glitches[n].clock > clock + reach) break;
                const away = clock < glitches[n].clock ? glitches[n].clock - clock : Math.max(0, clock - glitches[n].end);
                if (away <= distance && (best === null || away < distance)) [best, distance] = [glitches[n], away];
            }
            return best;
        }
        describeDisplay(display, clock) {
            const beam = run.beamAt(clock, display);
            if (!beam) return "waits for buffers, links or the swap";
            const stalled = (run.stalls[display].get(beam.frame) || []).some(([start, length]) => start <= clock && clock < start + length);
            const glitch = this.glitchNear(display, clock);
            return `composites frame ${beam.frame}, the top composer at ${beam.x}, ${beam.y}` + (stalled ? ", stands still" : "") +
                (glitch ? `; pixels of ${machine.renderers[glitch.renderer].name} starve at ${glitch.first}, ${glitch.y}` : "");
        }
        paintShown(top, height) {
            record.shown.forEach(([first], frame) => {
                const next = record.shown[frame + 1];
                const end = next && next[1] >= next[0] ? next[0] : run.cycles;
                if (end >= this.from && first <= this.to) this.span(first, end, top, height, frame % 2 ? "#7d6b3d" : "#94803f", [`frame ${frame}`, String(frame)]);
            });
        }
        describeShown(clock) {
            const frame = run.lastAtOrBefore(record.shown.map(([first]) => first), clock);
            return frame < 0 ? "no frame yet" : `frame ${frame}, since the swap at clock ${record.shown[frame][0].toLocaleString("en")}`;
        }

        // ----------------------------------------------------------------------------------------------------- buffers

        paintLevel(renderer, display, top, height) {
            const composer = run.composerOf(renderer, display), track = run.levels[composer].get(() => this.draw());
            const depth = machine.buffer_pixels, context = this.context;
            const safe = run.data.safe_buffer_pixels, most = depth * 1.06, yOf = level => top + height - level / most * (height - 2);
            if (track) {
                context.fillStyle = "#3f8fbf";
                if (this.clocksPerPixel < 0.5 && this.to <= track.known) {
                    const step = 1 / this.clocksPerPixel;
                    for (let clock = Math.floor(this.from); clock <= this.to; ++clock) {
                        const y = yOf(track.at(clock));
                        context.fillRect(this.xOf(clock), y, step - (step > 6 ? 1 : 0), top + height - y);
                    }
                } else {
                    for (let x = 0; x < this.plotWidth; ++x) {
                        const clock = this.clockAt(labelWidth + x);
                        const [least, high] = track.range(clock, clock + this.clocksPerPixel);
                        context.globalAlpha = 0.45;
                        context.fillRect(labelWidth + x, yOf(high), 1, yOf(least) - yOf(high));
                        context.globalAlpha = 1;
                        context.fillRect(labelWidth + x, yOf(least), 1, top + height - yOf(least));
                    }
                }
            }
            const line = (level, colour, dash) => {
                context.strokeStyle = colour;
                context.setLineDash(dash);
                context.beginPath();
                context.moveTo(labelWidth, yOf(level));
                context.lineTo(this.width, yOf(level));
                context.stroke();
                context.setLineDash([]);
            };
            line(depth, this.ink.quiet, []);
            if (safe !== null && safe < depth) line(safe, "#2fa36b", [4, 3]);
            const glitches = run.glitchesOf(display);
            for (let n = this.firstGlitch(glitches, this.from), drawn = -1; n < glitches.length && glitches[n].clock <= this.to; ++n) {
                if (glitches[n].renderer !== renderer) continue;
                const left = this.xOf(glitches[n].clock), right = this.xOf(glitches[n].end + 1);
                if (right < drawn + 0.4) continue;
                drawn = right;
                context.fillStyle = "#e3a600";
                context.fillRect(left, top + height - 4, Math.max(1, right - left), 4);
            }
        }
        describeLevel(renderer, display, clock) {
            const composer = run.composerOf(renderer, display), track = run.levels[composer].get(() => this.draw());
            if (!track) return "…";
            const counters = run.report.composers[composer], safe = run.data.safe_buffer_pixels;
            return `holds ${track.at(clock)} of ${machine.buffer_pixels} pixels; high water ${counters.buffer_high_water}` +
                (safe === null ? "" : `; ${safe} are proved to be enough`) +
                (counters.starved_pixels ? `; ${counters.starved_pixels.toLocaleString("en")} pixels starved` : "");
        }

        // ------------------------------------------------------------------------------------------------------- input

        rowAt(y) {
            const inside = y - axisHeight + this.scroll;
            return y < axisHeight ? null : this.rows.find(row => inside >= row.top && inside < row.top + row.height + 3) || null;
        }
        describe(x, y) {
            const row = this.rowAt(y);
            if (!row || x < labelWidth) return null;
            const clock = Math.floor(this.clockAt(x));
            return clock < 0 || clock >= run.cycles ? null : {row, clock, text: row.describe(clock)};
        }
        listen() {
            const canvas = this.canvas;
            let pressed = null;
            canvas.addEventListener("pointerdown", event => {
                if (event.button !== 0) return;
                pressed = {x: event.offsetX, y: event.offsetY, from: this.from, to: this.to, scroll: this.scroll, moved: false};
                canvas.setPointerCapture(event.pointerId);
            });
            canvas.addEventListener("pointermove", event => {
                if (!pressed) {
                    this.on.hover(this.describe(event.offsetX, event.offsetY), event);
                    return;
                }
                if (!pressed.moved && Math.hypot(event.offsetX - pressed.x, event.offsetY - pressed.y) <= 4) return;
                pressed.moved = true;
                const by = (pressed.x - event.offsetX) * (pressed.to - pressed.from) / this.plotWidth;
                this.scroll = clip(pressed.scroll + pressed.y - event.offsetY, 0, this.mostScroll);
                this.look(pressed.from + by, pressed.to + by);
            });
            canvas.addEventListener("pointerup", event => {
                const was = pressed;
                pressed = null;
                if (!was || was.moved || event.offsetX < labelWidth) return;
                const clock = this.clockAt(event.offsetX), row = this.rowAt(event.offsetY);
                const number = row && /^display (\d+)$/.exec(row.label);
                const glitch = number ? this.glitchNear(Number(number[1]) - 1, clock) : null;
                if (glitch) this.on.glitch(glitch); else this.on.clock(Math.floor(clock));
            });
            canvas.addEventListener("pointercancel", () => { pressed = null; });
            canvas.addEventListener("pointerleave", () => this.on.hover(null));
            canvas.addEventListener("wheel", event => {
                if (event.shiftKey || event.offsetX < labelWidth) {
                    if (!this.mostScroll) return;
                    this.scroll = clip(this.scroll + event.deltaY, 0, this.mostScroll);
                    this.draw();
                } else if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
                    this.moveBy(event.deltaX / this.plotWidth);
                } else if (event.deltaY > 0 && this.to - this.from >= run.cycles) {
                    return;     // nothing to zoom out of: the page scrolls
                } else {
                    this.zoomBy(Math.exp(event.deltaY * 0.0022), this.clockAt(event.offsetX));
                }
                event.preventDefault();
            }, {passive: false});
            canvas.addEventListener("dblclick", event => this.zoomBy(0.25, this.clockAt(event.offsetX)));
            canvas.addEventListener("keydown", event => {
                const keys = {ArrowLeft: () => this.moveBy(-0.15), ArrowRight: () => this.moveBy(0.15),
                              "+": () => this.zoomBy(0.5, this.middle()), "=": () => this.zoomBy(0.5, this.middle()),
                              "-": () => this.zoomBy(2, this.middle()), "0": () => this.look(0, run.cycles),
                              Home: () => this.look(0, this.to - this.from),
                              ArrowUp: () => this.scrollBy(-60), ArrowDown: () => this.scrollBy(60),
                              ",": () => this.on.clock((this.clock === null ? this.from : this.clock) - 1),
                              ".": () => this.on.clock((this.clock === null ? this.from : this.clock) + 1)};
                if (event.key === "End") {
                    const length = this.to - this.from;
                    this.look(run.cycles - length, run.cycles);
                } else if (keys[event.key]) {
                    keys[event.key]();
                } else {
                    return;
                }
                event.preventDefault();
            });
        }
        middle() {
            return this.clock !== null && this.clock >= this.from && this.clock < this.to ? this.clock : (this.from + this.to) / 2;
        }
        scrollBy(pixels) {
            this.scroll = clip(this.scroll + pixels, 0, this.mostScroll);
            this.draw();
        }
    }
    return {TimeLine};
})();
