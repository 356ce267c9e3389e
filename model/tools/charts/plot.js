// `metabuffer plot`: one chart as SVG on standard output, drawn in node.
function metabufferPlot(request) {
    'use strict';
    // Without a browser nothing measures text. These are the widths of the characters of DejaVu Sans from the space on,
    // in hundredths of the font's size. Debian's librsvg2-bin installs that font, and the chart names it first.
    const widths = [
        32, 40, 46, 84, 64, 95, 78, 27, 39,  39, 50, 84, 32, 36, 32, 34, 64, 64, 64, 64, 64, 64, 64, 64,
        64, 64, 34, 34, 84, 84, 84, 53, 100, 68, 69, 70, 77, 63, 58, 77, 75, 29, 29, 66, 56, 86, 75, 79,
        60, 79, 69, 63, 61, 73, 68, 99, 69,  61, 69, 39, 34, 39, 84, 50, 50, 61, 63, 55, 63, 62, 35, 63,
        63, 28, 28, 58, 28, 97, 63, 61, 63,  63, 41, 52, 39, 63, 59, 82, 59, 59, 52, 64, 34, 64, 84
    ];
    const widthOf = (text, size) => {
        let sum = 0;
        for (const letter of text) sum += widths[letter.codePointAt(0) - 32] || 64;
        return sum * size / 100;
    };
    vega.textMetrics.width = (item, text) => {
        const bold = Number(item.fontWeight) >= 600 || item.fontWeight === 'bold' ? 1.12 : 1;
        return widthOf(String(text), item.fontSize || 11) * bold;
    };

    const {width, height} = request;
    const draw = (w, h) => {
        const {spec} = metabufferCharts.build({
            font: 'DejaVu Sans, Verdana, sans-serif',
            fontSize: 13,
            labelLimit: 0,
            ...request,
            notesBelowTitle: true,
            width: w,
            height: h
        });
        return new vega.View(vega.parse(spec), {renderer: 'none', logLevel: vega.Warn}).toSVG();
    };
    const sizeOf = svg => /<svg[^>]* width="([\d.]+)" height="([\d.]+)"/.exec(svg).slice(1).map(Number);
    // Several panels have their own size, with legends and titles around them. The second drawing corrects for these.
    return draw(width, height)
        .then(svg => {
            const [w, h] = sizeOf(svg);
            const fits = Math.abs(w - width) <= 2 && Math.abs(h - height) <= 2;
            return fits ? svg : draw(2 * width - w, 2 * height - h);
        })
        .then(svg => {
            // Coordinates have fifteen digits, but no screen shows more than two after the decimal point.
            const short = svg.replace(/<[^>]*>/g, tag => tag.replace(/(\.\d\d)\d+/g, '$1'));
            process.stdout.write(short + '\n');
        });
}
