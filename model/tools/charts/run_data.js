// The page's data about its run: tracks of clocks, unpacked when they are first drawn, and what happened to each pixel.
// Clocks are core clocks. Frames count from 0. Renderers and displays count from 0 in the code and from 1 for the
// reader.
const metabufferRun = (() => {
    "use strict";
    const {inflated, clockKinds} = metabufferElements;
    const data = JSON.parse(document.getElementById("data").textContent);
    const {machine, record, report} = data;
    const renderers = machine.renderers.length;
    const displays = machine.columns * machine.rows;
    const sub = machine.supersample;
    const rasterWidth = machine.width * sub, rasterHeight = machine.height * sub, samples = sub * sub;
    const cycles = report.core_cycles;
    // Kinds of spans of a bus, by the number of the kind in a span. In a clock without a span the bus is idle.
    const uses = record.bus_uses.map(use => clockKinds.find(({counter}) => counter === use));
    const [pixelUse, tableUse, pageMissUse] = ["busy_cycles", "table_cycles", "page_miss_cycles"].map(counter =>
        record.bus_uses.indexOf(counter));
    const blockLength = 64;     // spans or points between two kept sums
    const farZ = 2 ** machine.depth.z_bits - 1;

    const clocksFromTo = (first, last) => `clocks ${first.toLocaleString("en")} to ${last.toLocaleString("en")}`;

    /// Reads back what NumberLog has written.
    class NumberReader {
        constructor(buffer) { this.bytes = new Uint8Array(buffer); this.at = 0; }
        next() {
            let number = 0, scale = 1;
            for (;;) {
                const byte = this.bytes[this.at++];
                number += (byte & 127) * scale;
                if (byte < 128) return number;
                scale *= 128;
            }
        }
        nextSigned() {
            const number = this.next();
            return number % 2 ? -(number + 1) / 2 : number / 2;
        }
    }

    /// The last index at which the value is at most `value`, or -1.
    function lastAtOrBefore(sorted, value, count = sorted.length) {
        let low = 0, high = count;
        while (low < high) {
            const middle = (low + high) >> 1;
            if (sorted[middle] <= value) low = middle + 1; else high = middle;
        }
        return low - 1;
    }

    /// A value that load() or the first get() starts to unpack. get() returns null until it is ready; only the
    /// `whenReady` of the call that started it is called then.
    class Later {
        constructor(make) { this.make = make; this.value = null; this.promise = null; }
        load() {
            if (!this.promise) this.promise = this.make().then(value => { this.value = value; return value; });
            return this.promise;
        }
        get(whenReady) {
            if (this.value === null && !this.promise) this.load().then(whenReady);
            return this.value;
        }
    }

    /// Bins replace the single spans and points that are left out.
    const binsOf = async track => track.bins === undefined ? new ArrayBuffer(0) : inflated(track.bins);

    // ------------------------------------------------------------------------------------------------------------ buses

    class BusTrack {
        /// `counted`: clocks by use from the report, which ends with the run. The last span may go on after the run's
        /// end.
        constructor(track, spans, bins, counted) {
            const count = track.count;
            this.known = track.left_out ? track.known_cycles : Infinity;  // single spans up to here
            this.starts = new Float64Array(count);
            this.lengths = new Float64Array(count);
            this.kinds = new Uint8Array(count);
            this.numbers = new Uint32Array(count);    // a display, from 1; of a table its frame
            this.pixels = new Uint32Array(count);
            this.recovered = new Uint32Array(count);
            this.sums = [];                           // before each block: clocks by use
            const reader = new NumberReader(spans), sum = new Float64Array(uses.length);
            let end = 0;
            for (let n = 0; n < count; ++n) {
                if (n % blockLength === 0) this.sums.push(sum.slice());
                const kind = this.kinds[n] = reader.next();
                this.starts[n] = end + reader.nextSigned();
                const length = reader.next();
                end = this.starts[n] + length;
                this.lengths[n] = Math.max(0, Math.min(end, cycles) - this.starts[n]);
                sum[kind] += this.lengths[n];
                if (kind === pixelUse || kind === tableUse || kind === pageMissUse) this.numbers[n] = reader.next();
                if (kind === pixelUse) {
                    this.pixels[n] = reader.next();
                    this.recovered[n] = reader.next();
                }
            }
            this.binCycles = track.bin_cycles;
            const binReader = new NumberReader(bins);
            this.binSums = [new Float64Array(uses.length)];
            while (binReader.at < binReader.bytes.length) {
                const next = this.binSums[this.binSums.length - 1].slice();
                for (let use = 0; use < uses.length; ++use) next[use] = Math.min(counted[use], next[use] + binReader.next());
                this.binSums.push(next);
            }
        }
        /// Writes the clocks of each use before a clock to `into`.
        before(clock, into) {
            if (clock > this.known) {
                const bin = Math.min(Math.floor(clock / this.binCycles), this.binSums.length - 1);
                const next = Math.min(bin + 1, this.binSums.length - 1), first = bin * this.binCycles;
                const share = Math.min(1, (clock - first) / Math.max(1, Math.min(this.binCycles, cycles - first)));
                for (let use = 0; use < uses.length; ++use) {
                    into[use] = this.binSums[bin][use] + share * (this.binSums[next][use] - this.binSums[bin][use]);
                }
                return into;
            }
            const last = lastAtOrBefore(this.starts, clock);
            if (last < 0) return into.fill(0);
            const block = Math.floor(last / blockLength);
            into.set(this.sums[block]);
            for (let n = block * blockLength; n < last; ++n) into[this.kinds[n]] += this.lengths[n];
            into[this.kinds[last]] += Math.min(this.lengths[last], clock - this.starts[last]);
            return into;
        }
        /// The span that contains a clock, or -1.
        at(clock) {
            const last = lastAtOrBefore(this.starts, clock);
            return last >= 0 && clock < this.starts[last] + this.lengths[last] ? last : -1;
        }
        describe(n) {
            const kind = this.kinds[n], clocks = clocksFromTo(this.starts[n], this.starts[n] + this.lengths[n] - 1);
            if (kind === pixelUse) {
                const slots = this.recovered[n];
                return `${this.pixels[n]} pixels for display ${this.numbers[n]}` +
                    (slots ? `, ${slots} slot${slots === 1 ? "" : "s"} recovered` : "") + `, ${clocks}`;
            }
            if (kind === tableUse) return `table of frame ${this.numbers[n]}, ${clocks}`;
            return `${uses[kind].name}${kind === pageMissUse ? ` for display ${this.numbers[n]}` : ""}, ${clocks}`;
        }
    }
    const buses = record.buses.map((track, n) => new Later(async () =>
        new BusTrack(track, await inflated(track.spans), await binsOf(track),
                     uses.map(({counter}) => report.renderers[n].bus[counter]))));

    // ---------------------------------------------------------------------------------------------------------- buffers

    class LevelTrack {
        constructor(track, points, bins) {
            this.known = track.left_out ? track.known_cycles : Infinity;
            this.clocks = new Float64Array(track.count);
            this.levels = new Int32Array(track.count);
            this.least = [];
            this.most = [];
            const reader = new NumberReader(points);
            let clock = 0, level = 0;
            for (let n = 0; n < track.count; ++n) {
                clock += reader.nextSigned();
                level += reader.nextSigned();
                this.clocks[n] = n ? Math.max(clock, this.clocks[n - 1]) : clock;
                this.levels[n] = level;
                const block = Math.floor(n / blockLength);
                this.least[block] = n % blockLength ? Math.min(this.least[block], level) : level;
                this.most[block] = n % blockLength ? Math.max(this.most[block], level) : level;
            }
            this.binCycles = track.bin_cycles;
            const binReader = new NumberReader(bins);
            this.bins = [];
            while (binReader.at < binReader.bytes.length) this.bins.push([binReader.next(), binReader.next()]);
        }
        /// The level at a clock. Between two points it changes linearly.
        at(clock) {
            if (clock > this.known) {
                const bin = this.bins[Math.floor(clock / this.binCycles)];
                return bin ? bin[1] : 0;
            }
            const n = lastAtOrBefore(this.clocks, clock);
            if (n < 0) return 0;
            if (n + 1 === this.clocks.length || this.clocks[n + 1] === this.clocks[n]) return this.levels[n];
            const share = (clock - this.clocks[n]) / (this.clocks[n + 1] - this.clocks[n]);
            return Math.round(this.levels[n] + share * (this.levels[n + 1] - this.levels[n]));
        }
        /// The least and the highest level in clocks from..to.
        range(from, to) {
            if (to > this.known) {
                let least = Infinity, most = 0;
                const last = Math.min(this.bins.length - 1, Math.floor(to / this.binCycles));
                for (let n = Math.max(0, Math.floor(from / this.binCycles)); n <= last; ++n) {
                    least = Math.min(least, this.bins[n][0]);
                    most = Math.max(most, this.bins[n][1]);
                }
                return least <= most ? [least, most] : [0, 0];
            }
            let least = this.at(from), most = least;
            const take = level => { least = Math.min(least, level); most = Math.max(most, level); };
            take(this.at(to));
            let n = lastAtOrBefore(this.clocks, from) + 1;
            const end = lastAtOrBefore(this.clocks, to);
            while (n <= end) {
                if (n % blockLength === 0 && n + blockLength - 1 <= end) {
                    take(this.least[n / blockLength]);
                    take(this.most[n / blockLength]);
                    n += blockLength;
                } else {
                    take(this.levels[n++]);
                }
            }
            return [least, most];
        }
    }
    const levels = record.levels.map(track => new Later(async () =>
        new LevelTrack(track, await inflated(track.points), await binsOf(track))));
    const composerOf = (renderer, display) => renderer * displays + display;

    // ------------------------------------------------------------------------------------------ starved pixels and clocks

    const stalls = record.stalls.map(() => new Map());   // of each display by frame: [start, clocks]
    const starved = record.starved.counts.map(() => new Map()); // of each composer by frame: [y, first x, last x]

    async function unpackStalls(display) {
        const track = record.stalls[display], reader = new NumberReader(await inflated(track.spans));
        let end = 0;
        for (let n = 0; n < track.count; ++n) {
            const start = end + reader.nextSigned(), length = reader.next(), frame = reader.next();
            end = start + length;
            if (!stalls[display].has(frame)) stalls[display].set(frame, []);
            stalls[display].get(frame).push([start, length]);
        }
    }
    async function unpackStarved() {
        const reader = new NumberReader(await inflated(record.starved.runs));
        record.starved.counts.forEach((count, composer) => {
            let frame = 0, y = 0, first = 0;
            for (let n = 0; n < count; ++n) {
                frame += reader.nextSigned();
                y += reader.nextSigned();
                first += reader.nextSigned();
                const run = [y, first, first + reader.next()];
                if (!starved[composer].has(frame)) starved[composer].set(frame, []);
                starved[composer].get(frame).push(run);
            }
        });
    }

    /// The clock in which a composer composites a raster pixel, or null. A column moves one raster position per clock,
    /// except in stalls; a composer is one clock later than the one above it.
    function clockOf(frame, display, renderer, x, y) {
        const spans = record.composited[frame];
        if (!spans || spans[display][1] < spans[display][0]) return null;
        let clock = spans[display][0] + renderer + y * rasterWidth + x;
        for (const [start, length] of stalls[display].get(frame) || []) {
            if (start > clock) break;
            clock += length;
        }
        return clock;
    }
    /// What the top composer of a display composites at a clock: {frame, x, y}, or null.
    function beamAt(clock, display) {
        let frame = frameAt(clock, display);
        if (frame < 0) return null;
        let position = clock - record.composited[frame][display][0];
        for (const [start, length] of stalls[display].get(frame) || []) {
            if (start > clock) break;
            position -= Math.min(length, clock - start + 1);
        }
        position = Math.max(0, position);
        if (position >= rasterWidth * rasterHeight) return null;
        return {frame, x: position % rasterWidth, y: Math.floor(position / rasterWidth)};
    }
    const starts = [...Array(displays).keys()].map(display => record.composited.map(spans => spans[display][0]));
    /// The frame that a display's column composites at a clock, or -1.
    function frameAt(clock, display) {
        const frame = lastAtOrBefore(starts[display], clock);
        return frame >= 0 && clock <= record.composited[frame][display][1] ? frame : -1;
    }

    const glitches = [...Array(displays).keys()].map(() => null);
    /// Every run of starved pixels of a display, in the order of clocks: {clock, end, display, renderer, frame, y,
    /// first, last}. Empty until all is unpacked.
    function glitchesOf(display) {
        if (!isUnpacked) return [];
        if (glitches[display]) return glitches[display];
        const list = [];
        for (let renderer = 0; renderer < renderers; ++renderer) {
            for (const [frame, runs] of starved[composerOf(renderer, display)]) {
                for (const [y, first, last] of runs) {
                    const clock = clockOf(frame, display, renderer, first, y);
                    if (clock === null) continue;
                    list.push({clock, end: clock + last - first, display, renderer, frame, y, first, last});
                }
            }
        }
        list.sort((a, b) => a.clock - b.clock);
        return glitches[display] = list;
    }

    /// Whether a raster pixel of a composer starved.
    function isStarved(renderer, display, frame, x, y) {
        const runs = starved[composerOf(renderer, display)].get(frame);
        if (!runs) return false;
        let low = 0, high = runs.length;
        while (low < high) {
            const middle = (low + high) >> 1, [row, , last] = runs[middle];
            if (row < y || (row === y && last < x)) low = middle + 1; else high = middle;
        }
        return low < runs.length && runs[low][0] === y && runs[low][1] <= x;
    }

    // --------------------------------------------------------------------------------------------------------- pictures

    const pngOf = number => Uint8Array.from(atob(document.getElementById("picture-" + number).textContent),
                                            letter => letter.charCodeAt(0));
    const bitmapOf = number => createImageBitmap(new Blob([pngOf(number)], {type: "image/png"}),
                                                 {colorSpaceConversion: "none", premultiplyAlpha: "none"});
    function pixelsOf(bitmap) {
        const canvas = document.createElement("canvas");
        canvas.width = bitmap.width;
        canvas.height = bitmap.height;
        const context = canvas.getContext("2d", {willReadFrequently: true});
        context.drawImage(bitmap, 0, 0);
        const bytes = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
        const pixels = new Uint32Array(bitmap.width * bitmap.height);
        for (let n = 0; n < pixels.length; ++n) pixels[n] = bytes[4 * n] * 65536 + bytes[4 * n + 1] * 256 + bytes[4 * n + 2];
        return pixels;
    }
    const shownBitmaps = new Map(), shownPixels = new Map();
    const mostBitmaps = 96;     // bitmaps of a whole run could be too large for the browser's memory
    async function remembered(map, key, make) {
        if (!map.has(key)) map.set(key, make());
        const value = map.get(key);
        map.delete(key);
        map.set(key, value);    // the most recently used is last
        if (map.size > mostBitmaps) map.delete(map.keys().next().value);
        return value;
    }
    const shownBitmap = number => remembered(shownBitmaps, number, () => bitmapOf(number));
    const shownPixelsOf = number => remembered(shownPixels, number, async () => pixelsOf(await shownBitmap(number)));

    const isKnownImage = number => data.images[number].colour !== undefined;
    const images = data.images.map((image, number) => new Later(async () => isKnownImage(number)
        ? {...image, colours: pixelsOf(await bitmapOf(image.colour)), depths: pixelsOf(await bitmapOf(image.depth))} : image));

    /// The images of a frame's contributions, unpacked; false if one is not in the page.
    async function loadImages(entry) {
        if (!entry.contributions) return false;
        const numbers = entry.contributions.filter(one => one).map(one => one.image);
        await Promise.all(numbers.map(number => images[number].load()));
        return numbers.every(isKnownImage);
    }

    const alphaMask = 2 ** machine.depth.alpha_bits - 1;
    const alphaOf = bits => machine.depth.alpha_bits ? (bits >>> machine.depth.alpha_shift) & alphaMask : 255;
    const zOf = bits => ((bits >>> machine.depth.z_shift) & farZ) >>> 0;

    /// The row of a renderer's table for a display, if it has one.
    function rowOf(entry, renderer, display) {
        const one = entry.contributions[renderer];
        return one ? data.tables[one.table].find(row => row[0] === display + 1) : undefined;
    }
    const smooths = machine.smoothing === "bilinear";
    const whole = 256;      // the weight of 1
    /// The source line next to that of a raster line, and its weight; the same line at the segment's edge.
    function besideAt(raster, destination, multiple, count, into) {
        const own = Math.floor((raster - destination) / multiple);
        const twice = 2 * (raster - destination - own * multiple) + 1 - multiple;
        const other = own + Math.sign(twice);
        into[0] = other < 0 || other >= count ? own : other;
        into[1] = Math.floor(whole * Math.abs(twice) / (2 * multiple));
    }
    /// R, G, B and A of a segment's raster pixel, mixed of its own source pixel and those around it. The result is in
    /// `mixture` until the next call.
    const mixture = new Uint8Array(4), inX = [0, 0], inY = [0, 0];
    function mix(image, row, x, y) {
        const [, sx, sy, sdx, sdy, dx, dy, multiple] = row;
        besideAt(x, dx, multiple, sdx, inX);
        besideAt(y, dy, multiple, sdy, inY);
        const ownX = sx + Math.floor((x - dx) / multiple), ownY = sy + Math.floor((y - dy) / multiple);
        const own = ownY * image.width + ownX;
        const isKeyed = machine.composition === "z-alpha-key";
        const isHidden = isKeyed && alphaOf(image.depths[own]) === 0;
        /// A pixel that the viewer does not see counts as the own one.
        const seen = index => isHidden || zOf(image.depths[index]) === farZ ||
            (isKeyed && alphaOf(image.depths[index]) === 0) ? own : index;
        const beside = seen(ownY * image.width + sx + inX[0]);
        const across = seen((sy + inY[0]) * image.width + ownX);
        const diagonal = seen((sy + inY[0]) * image.width + sx + inX[0]);
        const channel = of => (whole - inY[1]) * ((whole - inX[1]) * of(own) + inX[1] * of(beside)) +
            inY[1] * ((whole - inX[1]) * of(across) + inX[1] * of(diagonal)) + whole * whole / 2 >>> 16;
        mixture[0] = channel(index => image.colours[index] >>> 16);
        mixture[1] = channel(index => (image.colours[index] >>> 8) & 255);
        mixture[2] = channel(index => image.colours[index] & 255);
        mixture[3] = channel(index => alphaOf(image.depths[index]));
        return mixture;
    }

    /// The pixel that a renderer has for a raster pixel, or null if its segment does not cover it.
    function localPixel(entry, renderer, display, x, y) {
        const row = rowOf(entry, renderer, display);
        if (!row) return null;
        const [, sx, sy, sdx, sdy, dx, dy, multiple] = row;
        const i = Math.floor((x - dx) / multiple), j = Math.floor((y - dy) / multiple);
        if (i < 0 || j < 0 || i >= sdx || j >= sdy) return null;
        const number = entry.contributions[renderer].image, image = images[number].value;
        const pixel = {renderer, sourceX: sx + i, sourceY: sy + j, image: number,
                       starved: isStarved(renderer, display, entry.frame, x, y)};
        if (image && image.colours) {
            const index = pixel.sourceY * image.width + pixel.sourceX;
            pixel.colour = image.colours[index];
            pixel.alpha = alphaOf(image.depths[index]);
            pixel.z = zOf(image.depths[index]);
            if (smooths && multiple > 1) {
                const [r, g, b, a] = mix(image, row, x, y);
                pixel.colour = r * 65536 + g * 256 + b;
                pixel.alpha = a;
                pixel.isMixed = true;
            }
        }
        return pixel;
    }

    const divided = t => (t + 128 + ((t + 128) >> 8)) >> 8;
    function blended(front, back) {
        const over = (f, b) => Math.min(255, f + divided(b * (255 - front.alpha)));
        const channel = shift => over((front.colour >>> shift) & 255, (back.colour >>> shift) & 255) * 2 ** shift;
        return {colour: channel(16) + channel(8) + channel(0), alpha: over(front.alpha, back.alpha), z: front.z};
    }
    /// A pixel in the pipeline has colour, alpha and Z, and the renderer that won it last (-1: the background).
    const background = {colour: machine.background[0] * 65536 + machine.background[1] * 256 + machine.background[2],
                        alpha: 0, z: farZ, winner: -1};
    function composed(local, upstream) {
        const isNearer = local.z < upstream.z;
        if (machine.composition === "over") {
            const result = isNearer ? blended(local, upstream) : blended(upstream, local);
            return {...result, winner: isNearer ? local.renderer : upstream.winner};
        }
        if (!isNearer || (machine.composition === "z-alpha-key" && local.alpha === 0)) return upstream;
        return {colour: local.colour, alpha: local.alpha, z: local.z, winner: local.renderer};
    }
    /// What became of a raster pixel: what each renderer had for it, and the pixel that left the pipeline.
    function rasterPixel(entry, display, x, y) {
        const locals = [];
        let pixel = background, isWhole = true;
        for (let renderer = 0; renderer < renderers; ++renderer) {
            const local = localPixel(entry, renderer, display, x, y);
            if (!local) continue;
            locals.push(local);
            if (local.colour === undefined) isWhole = false;
            else if (!local.starved) pixel = composed(local, pixel);
        }
        return {locals, pixel, isWhole};
    }

    /// The renderer that won each shown pixel of a display, or -1. If a shown pixel has several raster pixels, it is
    /// the winner of the top left one. The images must have been loaded.
    function winners(entry, display) {
        const {width, height} = machine, map = new Int32Array(width * height).fill(-1);
        if (machine.composition === "over") {
            for (let n = 0; n < map.length; ++n) {
                map[n] = rasterPixel(entry, display, n % width * sub, Math.floor(n / width) * sub).pixel.winner;
            }
            return map;
        }
        const nearest = new Uint32Array(width * height).fill(farZ), keyed = machine.composition === "z-alpha-key";
        for (let renderer = 0; renderer < renderers; ++renderer) {
            const row = rowOf(entry, renderer, display);
            if (!row) continue;
            const [, sx, sy, sdx, sdy, dx, dy, multiple] = row, image = images[entry.contributions[renderer].image].value;
            const hasStarved = starved[composerOf(renderer, display)].has(entry.frame);
            const right = Math.min(width, Math.ceil((dx + sdx * multiple) / sub));
            const bottom = Math.min(height, Math.ceil((dy + sdy * multiple) / sub));
            for (let v = Math.max(0, Math.ceil(dy / sub)); v < bottom; ++v) {
                const line = (sy + Math.floor((v * sub - dy) / multiple)) * image.width + sx;
                for (let u = Math.max(0, Math.ceil(dx / sub)); u < right; ++u) {
                    const bits = image.depths[line + Math.floor((u * sub - dx) / multiple)], z = zOf(bits), n = v * width + u;
                    if (z >= nearest[n] || (keyed && alphaOf(bits) === 0)) continue;
                    if (hasStarved && isStarved(renderer, display, entry.frame, u * sub, v * sub)) continue;
                    nearest[n] = z;
                    map[n] = renderer;
                }
            }
        }
        return map;
    }

    /// The mean of a shown pixel's channels, corrected by the display's table if it has one.
    const mean = sum => Math.floor((sum + Math.floor(samples / 2)) / samples);
    function shownColour(display, red, green, blue) {
        const means = [mean(red), mean(green), mean(blue)], tables = machine.corrections[display];
        const [r, g, b] = tables ? means.map((value, n) => tables[n][value]) : means;
        return r * 65536 + g * 256 + b;
    }
    /// The colour that the display shows for a shown pixel, of what its raster pixels were; null if that is not known.
    function shownPixel(entry, display, u, v) {
        const sums = [0, 0, 0];
        for (let n = 0; n < samples; ++n) {
            const {pixel, isWhole} = rasterPixel(entry, display, u * sub + n % sub, v * sub + Math.floor(n / sub));
            if (!isWhole) return null;
            [16, 8, 0].forEach((shift, channel) => { sums[channel] += (pixel.colour >>> shift) & 255; });
        }
        return shownColour(display, ...sums);
    }

    /// Colours of one shown row of a display as if every local pixel had come in time. The images must have been
    /// loaded. No object is made for a pixel, since a wall with glitches has millions of pixels.
    const plane = {z: new Uint32Array(rasterWidth), alpha: new Uint8Array(rasterWidth), red: new Uint8Array(rasterWidth),
                   green: new Uint8Array(rasterWidth), blue: new Uint8Array(rasterWidth)};
    const rowSums = new Uint32Array(3 * machine.width);
    function idealRow(entry, display, v, colours) {
        const {z, alpha, red, green, blue} = plane, isOver = machine.composition === "over";
        const isKeyed = machine.composition === "z-alpha-key";
        rowSums.fill(0);
        for (let y = v * sub; y < (v + 1) * sub; ++y) {
            z.fill(farZ);
            alpha.fill(0);
            [red, green, blue].forEach((channel, n) => channel.fill(machine.background[n]));
            for (let renderer = 0; renderer < renderers; ++renderer) {
                const row = rowOf(entry, renderer, display);
                if (!row) continue;
                const [, sx, sy, sdx, sdy, dx, dy, multiple] = row, j = Math.floor((y - dy) / multiple);
                if (j < 0 || j >= sdy) continue;
                const image = images[entry.contributions[renderer].image].value, line = (sy + j) * image.width + sx;
                const end = Math.min(rasterWidth, dx + sdx * multiple);
                for (let x = Math.max(0, dx); x < end; ++x) {
                    const index = line + Math.floor((x - dx) / multiple), bits = image.depths[index], nearness = zOf(bits);
                    const isNearer = nearness < z[x];
                    let localAlpha = alphaOf(bits);
                    if (!isOver && (!isNearer || (isKeyed && localAlpha === 0))) continue;
                    const colour = image.colours[index];
                    let r = colour >>> 16, g = (colour >>> 8) & 255, b = colour & 255;
                    if (smooths && multiple > 1) [r, g, b, localAlpha] = mix(image, row, x, y);
                    if (isOver) {
                        const through = 255 - (isNearer ? localAlpha : alpha[x]);
                        const over = (mine, there) => isNearer ? Math.min(255, mine + divided(there * through))
                            : Math.min(255, there + divided(mine * through));
                        red[x] = over(r, red[x]);
                        green[x] = over(g, green[x]);
                        blue[x] = over(b, blue[x]);
                        alpha[x] = over(localAlpha, alpha[x]);
                    } else {
                        red[x] = r;
                        green[x] = g;
                        blue[x] = b;
                    }
                    if (isNearer) z[x] = nearness;
                }
            }
            for (let x = 0; x < rasterWidth; ++x) {
                const n = 3 * Math.floor(x / sub);
                rowSums[n] += red[x];
                rowSums[n + 1] += green[x];
                rowSums[n + 2] += blue[x];
            }
        }
        for (let u = 0; u < machine.width; ++u) {
            colours[u] = shownColour(display, rowSums[3 * u], rowSums[3 * u + 1], rowSums[3 * u + 2]);
        }
        return colours;
    }

    /// A map of shown pixels: 1 where a raster pixel starved, 2 where the display therefore shows a wrong colour.
    async function starvedMap(entry, display) {
        const {width, height} = machine, map = new Uint8Array(width * height), isHurt = new Uint8Array(height);
        for (let renderer = 0; renderer < renderers; ++renderer) {
            for (const [y, first, last] of starved[composerOf(renderer, display)].get(entry.frame) || []) {
                const row = Math.floor(y / sub);
                map.fill(1, row * width + Math.floor(first / sub), row * width + Math.floor(last / sub) + 1);
                isHurt[row] = 1;
            }
        }
        if (!isHurt.includes(1) || entry.pictures[display] === null || !await loadImages(entry)) return map;
        const shown = await shownPixelsOf(entry.pictures[display]), colours = new Uint32Array(width);
        for (let v = 0; v < height; ++v) {
            if (!isHurt[v]) continue;
            idealRow(entry, display, v, colours);
            for (let u = 0, n = v * width; u < width; ++u, ++n) if (map[n] && colours[u] !== shown[n]) map[n] = 2;
        }
        return map;
    }

    let isUnpacked = false;
    const ready = Promise.all([unpackStarved(), ...record.stalls.map((track, display) => unpackStalls(display))])
        .then(() => { isUnpacked = true; });
    return {data, machine, record, report, renderers, displays, rasterWidth, rasterHeight, cycles, uses, pixelUse, tableUse,
            clocksFromTo, farZ, ready, buses, levels, composerOf, stalls, starved, clockOf, beamAt, frameAt, glitchesOf, isStarved, lastAtOrBefore,
            shownBitmap, shownPixelsOf, loadImages, isKnownImage, rasterPixel, shownPixel, winners, starvedMap};
})();
