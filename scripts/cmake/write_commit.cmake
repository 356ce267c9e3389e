cmake_policy(VERSION 3.25)
# Writes OUTPUT, a header with the commit of SOURCE as METABUFFER_COMMIT, unless it has that commit already. The commit
# of a tree without git is empty.
execute_process(COMMAND git describe --always --exclude=* --abbrev=12 --dirty=-changed
                WORKING_DIRECTORY "${SOURCE}" OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#define METABUFFER_COMMIT \"@commit@\"\n" @ONLY)
