# Joins Vega's components to one script: OUTPUT, from COMPONENTS (names) in FILES, with what is in SOURCES around them.
file(READ "${SOURCES}/vega_modules.js" before)
file(READ "${SOURCES}/vega_index.js" after)
file(WRITE "${OUTPUT}.part" "${before}")
foreach(name file IN ZIP_LISTS COMPONENTS FILES)
    file(READ "${file}" text)
    # The maps are not there where the script ends up.
    string(REGEX REPLACE "\n//# sourceMappingURL=[^\n]*" "" text "${text}")
    file(APPEND "${OUTPUT}.part"
         "vegaModules.set(\"${name}\", function (module, exports, require) {\n" "${text}" "\n});\n")
endforeach()
file(APPEND "${OUTPUT}.part" "${after}")
file(RENAME "${OUTPUT}.part" "${OUTPUT}")
