// Debian's Vega comes as components that require() one another. Each is wrapped as a function of this list when the
// program is built, so that the whole is one script for browsers and for node.
const vegaModules = new Map();  // name: function (module, exports, require)
const vegaLoaded = new Map();

function vegaRequire(name) {
    if (vegaLoaded.has(name)) return vegaLoaded.get(name).exports;
    const define = vegaModules.get(name);
    if (define === undefined) throw new Error("Vega's component " + name + " is not in this bundle");
    const module = {exports: {}};
    vegaLoaded.set(name, module);
    define(module, module.exports, vegaRequire);
    return module.exports;
}
