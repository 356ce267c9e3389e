cmake_policy(VERSION 3.25)
# Writes OUTPUT, a header with the commit of SOURCE as METABUFFER_COMMIT, if it is another than it says already. A tree
# without git has none.
execute_process(COMMAND git describe --always --exclude=* --abbrev=12 --dirty=-changed
                WORKING_DIRECTORY "${SOURCE}" OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#define METABUFFER_COMMIT \"@commit@\"\n" @ONLY)
