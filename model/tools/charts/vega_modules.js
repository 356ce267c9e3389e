/*
This page contains Vega. Vega's licence requires this notice:

Copyright (c) 2015-2021, University of Washington Interactive Data Lab. All rights reserved.

Redistribution and use in source and binary forms, with or without modification, are permitted provided that the following
conditions are met:
1. Redistributions of source code must retain the above copyright notice, this list of conditions and the following
   disclaimer.
2. Redistributions in binary form must reproduce the above copyright notice, this list of conditions and the following
   disclaimer in the documentation and/or other materials provided with the distribution.
3. Neither the name of the copyright holder nor the names of its contributors may be used to endorse or promote products
   derived from this software without specific prior written permission.

THIS SOFTWARE IS PROVIDED BY THE COPYRIGHT HOLDERS AND CONTRIBUTORS "AS IS" AND ANY EXPRESS OR IMPLIED WARRANTIES, INCLUDING,
BUT NOT LIMITED TO, THE IMPLIED WARRANTIES OF MERCHANTABILITY AND FITNESS FOR A PARTICULAR PURPOSE ARE DISCLAIMED. IN NO
EVENT SHALL THE COPYRIGHT HOLDER OR CONTRIBUTORS BE LIABLE FOR ANY DIRECT, INDIRECT, INCIDENTAL, SPECIAL, EXEMPLARY, OR
CONSEQUENTIAL DAMAGES (INCLUDING, BUT NOT LIMITED TO, PROCUREMENT OF SUBSTITUTE GOODS OR SERVICES; LOSS OF USE, DATA, OR
PROFITS; OR BUSINESS INTERRUPTION) HOWEVER CAUSED AND ON ANY THEORY OF LIABILITY, WHETHER IN CONTRACT, STRICT LIABILITY, OR
TORT (INCLUDING NEGLIGENCE OR OTHERWISE) ARISING IN ANY WAY OUT OF THE USE OF THIS SOFTWARE, EVEN IF ADVISED OF THE
POSSIBILITY OF SUCH DAMAGE.

Its expression parser is based on Esprima (Copyright 2011-2013 Ariya Hidayat and others), under conditions 1 and 2 above and
the same disclaimer. Vega contains parts of D3 (Copyright 2010-2021 Mike Bostock, ISC licence: permission to use, copy,
modify, and/or distribute this software for any purpose with or without fee is hereby granted, provided that the above
copyright notice and this permission notice appear in all copies; the software is provided "as is" and the author
disclaims all warranties).
*/
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
