# metabuffer_add_replacements(BASE FOLDER...): adds folders with replacements of metabuffer_rtl's blocks. They come from
# METABUFFER_REPLACEMENT, or from metabuffer_levels_with() of the installed package. Their paths are relative to BASE.
function(metabuffer_add_replacements base)
    set(number 0)
    foreach(folder IN LISTS ARGN)
        get_filename_component(folder "${folder}" ABSOLUTE BASE_DIR "${base}")
        # This folder comes before model/, so that everything includes its rtl/BLOCK.h.
        target_include_directories(metabuffer_rtl BEFORE PUBLIC "$<BUILD_INTERFACE:${folder}>")
        math(EXPR number "${number} + 1")
        add_subdirectory("${folder}" "${CMAKE_CURRENT_BINARY_DIR}/replacement_${number}")
    endforeach()
endfunction()

# metabuffer_replace(BLOCKS NAME... SOURCES FILE... [LIBRARIES TARGET...] [REPLICATES_ONLY]): for the CMakeLists.txt of a
# folder of METABUFFER_REPLACEMENT, or of metabuffer_levels_with() of the installed package. In level rtl's library these
# sources take the place of the blocks' own. REPLICATES_ONLY: a composer or FIFO among them does not smooth, so the tests
# have no machine that does.
function(metabuffer_replace)
    cmake_parse_arguments(ARG "REPLICATES_ONLY" "" "BLOCKS;SOURCES;LIBRARIES" ${ARGN})
    get_target_property(sources metabuffer_rtl SOURCES)
    foreach(block IN LISTS ARG_BLOCKS)
        set(own "${sources}")
        list(FILTER own INCLUDE REGEX "(^|/)${block}\\.cpp$")
        if(NOT own)
            message(FATAL_ERROR "${CMAKE_CURRENT_SOURCE_DIR}: model/rtl has no block ${block}, or it is replaced twice")
        endif()
        if(NOT EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/rtl/${block}.h")
            message(FATAL_ERROR "${CMAKE_CURRENT_SOURCE_DIR}: a replacement of ${block} needs a header rtl/${block}.h")
        endif()
        list(REMOVE_ITEM sources ${own})
    endforeach()
    set_target_properties(metabuffer_rtl PROPERTIES SOURCES "${sources}")
    list(TRANSFORM ARG_SOURCES PREPEND "${CMAKE_CURRENT_SOURCE_DIR}/")
    target_sources(metabuffer_rtl PRIVATE ${ARG_SOURCES})
    # Another author's block has includes and an order of its own, which joined or precompiled files could break.
    set_source_files_properties(${ARG_SOURCES} TARGET_DIRECTORY metabuffer_rtl PROPERTIES
                                SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
    target_link_libraries(metabuffer_rtl PUBLIC ${ARG_LIBRARIES})
    if(ARG_REPLICATES_ONLY)
        set_property(GLOBAL PROPERTY METABUFFER_REPLICATES_ONLY ON)
    endif()
endfunction()
