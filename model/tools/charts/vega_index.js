// Does what Vega's own index does, except for the components that no chart here needs: maps, forces, word clouds,
// trees.
const vega = (() => {
    const transforms = vegaRequire("vega-dataflow").transforms;
    for (const name of ["vega-transforms", "vega-view-transforms", "vega-encode"])
        Object.assign(transforms, vegaRequire(name));
    const {View} = vegaRequire("vega-view");
    const {parse} = vegaRequire("vega-parser");
    const {textMetrics} = vegaRequire("vega-scenegraph");
    const {format} = vegaRequire("vega-format").defaultLocale();
    return {View, parse, textMetrics, format, Warn: vegaRequire("vega-util").Warn};
})();
