cmake_policy(VERSION 3.25)
# Writes OUTPUT, a header with the commit of SOURCE as METABUFFER_COMMIT, unless it has that commit already. Where files
# differ from the commit, or there is none, a digest of the sources follows, so that builds of different
# sources are never taken for the same.
execute_process(COMMAND git rev-parse --show-prefix WORKING_DIRECTORY "${SOURCE}"
                OUTPUT_VARIABLE folder ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE status)
if(status EQUAL 0 AND folder STREQUAL "")  # not a folder of some other project's
    execute_process(COMMAND git describe --always --exclude=* --abbrev=12 --dirty=-changed
                    WORKING_DIRECTORY "${SOURCE}" OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
endif()
if(NOT commit)
    set(commit "unknown commit")
endif()
if(commit MATCHES "(unknown commit|-changed)$")
    file(GLOB_RECURSE sources "${SOURCE}/model/*" "${SOURCE}/python/*.cpp" "${SOURCE}/python/*.h")
    set(digests "")
    foreach(file IN LISTS sources)
        file(SHA256 "${file}" digest)
        string(APPEND digests "${digest}")
    endforeach()
    string(SHA256 digest "${digests}")
    string(SUBSTRING "${digest}" 0 12 digest)
    string(REGEX REPLACE "commit$" "commit, sources ${digest}" commit "${commit}")
    string(REGEX REPLACE "changed$" "changed-${digest}" commit "${commit}")
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#define METABUFFER_COMMIT \"@commit@\"\n" @ONLY)
