# Joins Vega's components into one script, OUTPUT. COMPONENTS are their names and FILES their files. The folder SOURCES
# has the scripts that go before and after them.
file(READ "${SOURCES}/vega_modules.js" before)
file(READ "${SOURCES}/vega_index.js" after)
file(WRITE "${OUTPUT}.part" "${before}")
foreach(name file IN ZIP_LISTS COMPONENTS FILES)
    file(READ "${file}" text)
    # The program does not contain the source maps.
    string(REGEX REPLACE "\n//# sourceMappingURL=[^\n]*" "" text "${text}")
    file(APPEND "${OUTPUT}.part"
         "vegaModules.set(\"${name}\", function (module, exports, require) {\n" "${text}" "\n});\n")
endforeach()
file(APPEND "${OUTPUT}.part" "${after}")
file(RENAME "${OUTPUT}.part" "${OUTPUT}")
