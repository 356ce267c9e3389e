// Draws the displays as they hang on the wall, frame by frame, down to single raster pixels.
const metabufferWall = (() => {
    "use strict";
    const {sizeCanvas} = metabufferElements;
    const run = metabufferRun, {machine} = run;
    const gap = 6;                  // shown pixels between two displays
    const mostZoom = 48;
    const wallWidth = machine.columns * (machine.width + gap) - gap;
    const wallHeight = machine.rows * (machine.height + gap) - gap;
    const cornerOf = display => [display % machine.columns * (machine.width + gap),
                                Math.floor(display / machine.columns) * (machine.height + gap)];

    /// A colour for each renderer. The colours differ as much as so many can.
    function rendererColour(renderer) {
        const named = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#f0e442"];
        return renderer < named.length ? named[renderer] : `hsl(${Math.round(renderer * 137.508) % 360} 62% ${42 + renderer * 7 % 30}%)`;
    }
    const numberOf = (() => {       // 0xBBGGRR, as pixels of a canvas are
        const context = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
        const known = new Map();
        return colour => {
            if (!known.has(colour)) {
                context.fillStyle = colour;
                context.fillRect(0, 0, 1, 1);
                const [red, green, blue] = context.getImageData(0, 0, 1, 1).data;
                known.set(colour, red + green * 256 + blue * 65536);
            }
            return known.get(colour);
        };
    })();

    /// A map of shown pixels as a picture: `colourOf` gives 0xBBGGRR, or null for a transparent pixel.
    function painted(map, colourOf, alpha = 255) {
        const canvas = document.createElement("canvas");
        canvas.width = machine.width;
        canvas.height = machine.height;
        const context = canvas.getContext("2d"), image = context.createImageData(machine.width, machine.height);
        const pixels = new Uint32Array(image.data.buffer), colours = new Map();
        for (let n = 0; n < map.length; ++n) {
            if (!colours.has(map[n])) {
                const colour = colourOf(map[n]);
                colours.set(map[n], colour === null ? 0 : (colour + alpha * 2 ** 24) >>> 0);
            }
            pixels[n] = colours.get(map[n]);
        }
        context.putImageData(image, 0, 0);
        return canvas;
    }

    class Wall {
        /// on.pixel(pixel, pinned): a click or a key chose a raster pixel {display, x, y}, or null. on.hover(pixel):
        /// the mouse is over it. on.open(pixel): Enter opens it.
        constructor(canvas, on) {
            this.canvas = canvas;
            this.on = on;
            this.entry = null;      // of data.frames
            this.view = "picture";
            this.marks = {starved: true, wrong: true};
            this.layers = null;
            this.chosen = null;     // {display, x, y}, in raster pixels
            this.beams = [];        // {display, x, y}: what is composited at the chosen clock
            this.zoom = 0;          // 0: all of it
            this.left = this.top = 0;
            this.generation = 0;
            this.listen();
            new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
            this.resize();
        }

        resize() {
            const width = Math.max(200, Math.floor(this.canvas.parentElement.clientWidth));
            const height = Math.round(Math.min(560, Math.max(160, Math.min(width * wallHeight / wallWidth, window.innerHeight * 0.55))));
            if (sizeCanvas(this, width, height)) this.draw();
        }
        get fitting() { return Math.min(this.width / wallWidth, this.height / wallHeight); }
        get scale() { return this.zoom || this.fitting; }
        get origin() {
            if (this.zoom) return [-this.left * this.zoom, -this.top * this.zoom];
            return [(this.width - wallWidth * this.scale) / 2, (this.height - wallHeight * this.scale) / 2];
        }

        async show(entry, view = this.view) {
            this.entry = entry;
            this.view = view;
            const generation = ++this.generation;
            const layers = [], bitmaps = entry.pictures.map(number => number === null ? null : run.shownBitmap(number));
            for (let display = 0; display < run.displays; ++display) {
                const bitmap = await bitmaps[display], glitches = await run.starvedMap(entry, display);
                layers.push({bitmap, glitches});
                await new Promise(next => setTimeout(next));    // lets the browser handle input in between
                if (generation !== this.generation) return;
            }
            const hasImages = entry.contributions ? await run.loadImages(entry) : false;
            if (generation !== this.generation) return;     // the user has chosen another frame or view
            this.layers = layers.map(({bitmap, glitches}, display) => ({
                bitmap,
                winners: view === "winner" && hasImages
                    ? painted(run.winners(entry, display), renderer => renderer < 0 ? null : numberOf(rendererColour(renderer))) : null,
                glitches: glitches.some(mark => mark) ? glitches : null, painted: new Map()}));
            this.hasImages = hasImages;
            this.draw();
        }
        marksOf(layer) {
            if (!layer.glitches) return null;
            const key = `${this.marks.starved} ${this.marks.wrong}`;
            if (!layer.painted.has(key)) {
                layer.painted.set(key, painted(layer.glitches, mark => mark === 2 && this.marks.wrong ? numberOf("#ff1f5a")
                    : mark && this.marks.starved ? numberOf("#ffd400") : null, 150));
            }
            return layer.painted.get(key);
        }

        draw() {
            if (this.waiting) return;
            this.waiting = true;
            requestAnimationFrame(() => { this.waiting = false; this.paint(); });
        }
        paint() {
            const context = this.canvas.getContext("2d"), scale = this.scale, [left, top] = this.origin;
            context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
            context.clearRect(0, 0, this.width, this.height);
            context.imageSmoothingEnabled = scale * this.ratio < 1;
            context.imageSmoothingQuality = "high";
            const style = getComputedStyle(document.documentElement);
            for (let display = 0; display < run.displays; ++display) {
                const [x, y] = cornerOf(display).map((value, n) => value * scale + [left, top][n]);
                const width = machine.width * scale, height = machine.height * scale;
                context.fillStyle = style.getPropertyValue("--surface");
                context.fillRect(x, y, width, height);
                const layer = this.layers && this.layers[display];
                if (layer) {
                    if (this.view === "winner" && layer.winners) context.drawImage(layer.winners, x, y, width, height);
                    else if (layer.bitmap) context.drawImage(layer.bitmap, x, y, width, height);
                    const marks = this.marksOf(layer);
                    if (marks) context.drawImage(marks, x, y, width, height);
                }
                context.strokeStyle = style.getPropertyValue("--line");
                context.lineWidth = 1;
                context.strokeRect(x - 0.5, y - 0.5, width + 1, height + 1);
            }
            for (const beam of this.beams) this.mark(context, beam, "#00d0ff");
            if (this.chosen) this.mark(context, this.chosen, "#ff00ff");
        }
        mark(context, {display, x, y}, colour) {
            const scale = this.scale / machine.supersample, [left, top] = this.origin, [column, row] = cornerOf(display);
            const u = (column * machine.supersample + x) * scale + left, v = (row * machine.supersample + y) * scale + top;
            const size = Math.max(scale, 2);
            context.lineWidth = 1.5;
            for (const [style, grow] of [["rgba(0,0,0,.65)", 2.5], [colour, 1]]) {
                context.strokeStyle = style;
                context.strokeRect(u - grow, v - grow, size + 2 * grow, size + 2 * grow);
                context.beginPath();
                for (const [a, b, c, d] of [[-14, 0.5, -5, 0.5], [5, 0.5, 14, 0.5], [0.5, -14, 0.5, -5], [0.5, 5, 0.5, 14]]) {
                    const at = (value, from) => from + (value > 1 ? size + value : value < 0 ? value : size * value);
                    context.moveTo(at(a, u), at(b, v));
                    context.lineTo(at(c, u), at(d, v));
                }
                context.stroke();
            }
        }

        /// The raster pixel under a point of the canvas, or null.
        pixelAt(u, v) {
            const scale = this.scale, [left, top] = this.origin;
            const x = (u - left) / scale, y = (v - top) / scale;
            const column = Math.floor(x / (machine.width + gap)), row = Math.floor(y / (machine.height + gap));
            const inX = x - column * (machine.width + gap), inY = y - row * (machine.height + gap);
            if (column < 0 || row < 0 || column >= machine.columns || row >= machine.rows || inX >= machine.width ||
                inY >= machine.height) return null;
            return {display: row * machine.columns + column, x: Math.floor(inX * machine.supersample),
                    y: Math.floor(inY * machine.supersample)};
        }
        /// The point that stays where it is when zooming without a mouse: the chosen pixel if it is visible, else the
        /// middle.
        focus() {
            const {width, height, scale, origin: [left, top]} = this;
            if (!this.chosen) return [width / 2, height / 2];
            const [column, row] = cornerOf(this.chosen.display);
            const u = (column + (this.chosen.x + 0.5) / machine.supersample) * scale + left;
            const v = (row + (this.chosen.y + 0.5) / machine.supersample) * scale + top;
            return u >= 0 && v >= 0 && u < width && v < height ? [u, v] : [width / 2, height / 2];
        }
        zoomBy(factor, [u, v] = this.focus()) {
            const scale = this.scale, [left, top] = this.origin, next = Math.min(mostZoom, scale * factor);
            const x = (u - left) / scale, y = (v - top) / scale;
            if (next <= this.fitting * 1.001) {
                this.zoom = 0;
            } else {
                this.zoom = next;
                this.left = x - u / next;
                this.top = y - v / next;
            }
            this.draw();
        }
        /// Moves the view so that the chosen pixel is visible.
        reveal() {
            if (!this.chosen || !this.zoom) return;
            const [column, row] = cornerOf(this.chosen.display), margin = 24 / this.zoom;
            const x = column + this.chosen.x / machine.supersample, y = row + this.chosen.y / machine.supersample;
            const width = this.width / this.zoom, height = this.height / this.zoom;
            if (x < this.left + margin || x > this.left + width - margin) this.left = x - width / 2;
            if (y < this.top + margin || y > this.top + height - margin) this.top = y - height / 2;
        }
        choose(pixel, pinned) {
            this.chosen = pixel;
            if (pinned) this.reveal();
            this.draw();
            this.on.pixel(pixel, pinned);
        }

        listen() {
            const canvas = this.canvas;
            let pressed = null;
            canvas.addEventListener("pointerdown", event => {
                if (event.button !== 0) return;
                pressed = {u: event.offsetX, v: event.offsetY, left: this.left, top: this.top, moved: false};
                canvas.setPointerCapture(event.pointerId);
            });
            canvas.addEventListener("pointermove", event => {
                if (pressed && (pressed.moved || Math.hypot(event.offsetX - pressed.u, event.offsetY - pressed.v) > 4)) {
                    pressed.moved = true;
                    if (this.zoom) {
                        this.left = pressed.left - (event.offsetX - pressed.u) / this.zoom;
                        this.top = pressed.top - (event.offsetY - pressed.v) / this.zoom;
                        this.draw();
                    }
                } else if (!pressed) {
                    this.on.hover(this.pixelAt(event.offsetX, event.offsetY));
                }
            });
            canvas.addEventListener("pointerup", event => {
                if (pressed && !pressed.moved) this.choose(this.pixelAt(event.offsetX, event.offsetY), true);
                pressed = null;
            });
            canvas.addEventListener("pointercancel", () => { pressed = null; });
            canvas.addEventListener("pointerleave", () => this.on.hover(null));
            canvas.addEventListener("wheel", event => {
                if (!this.zoom && event.deltaY > 0) return;     // nothing to zoom out of: the page scrolls
                event.preventDefault();
                this.zoomBy(Math.exp(-event.deltaY * 0.0018), [event.offsetX, event.offsetY]);
            }, {passive: false});
            canvas.addEventListener("keydown", event => {
                const step = event.shiftKey ? 16 : 1;
                const moves = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step]};
                if (moves[event.key]) {
                    const pixel = this.chosen || {display: 0, x: 0, y: 0}, [right, down] = moves[event.key];
                    this.choose(this.chosen ? {...pixel, x: Math.min(run.rasterWidth - 1, Math.max(0, pixel.x + right)),
                                                y: Math.min(run.rasterHeight - 1, Math.max(0, pixel.y + down))} : pixel, true);
                } else if (event.key === "+" || event.key === "=") {
                    this.zoomBy(1.5);
                } else if (event.key === "-") {
                    this.zoomBy(1 / 1.5);
                } else if (event.key === "0") {
                    this.zoomBy(1e-9);
                } else if (event.key === "Enter" && this.chosen) {
                    this.on.open(this.chosen);
                } else {
                    return;
                }
                event.preventDefault();
            });
        }
    }
    return {Wall, rendererColour};
})();
