# Compiler settings and the two kinds of target that Loopline builds: plugin libraries and test programs.

add_library(loopline_settings INTERFACE)
target_compile_options(loopline_settings INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor)
# Bit-equal results on every build: no contraction of a*b+c that one compiler does and another does not.
target_compile_options(loopline_settings INTERFACE -ffp-contract=off)
# Loops become vector instructions: square roots set no errno, and what is computed and then not used may be infinite.
target_compile_options(loopline_settings INTERFACE -fno-math-errno -fno-trapping-math)
# Sources are named from the project's folder, wherever that lies: the same bytes from any checkout.
target_compile_options(loopline_settings INTERFACE -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=)
if(LOOPLINE_SANITIZE)
    # Null, misaligned and stray pointers are AddressSanitizer's: a second check of each takes twice the time to compile,
    # and finds Eigen's references into matrices without elements, which nobody follows.
    target_compile_options(loopline_settings INTERFACE -fsanitize=address,undefined -fno-omit-frame-pointer
        -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow -fno-sanitize-recover=undefined)
    target_link_options(loopline_settings INTERFACE -fsanitize=address,undefined)
    # Under AddressSanitizer Eigen would allocate in another way than it does in MRPT's libraries, whose functions for it
    # bear the same names.
    target_compile_definitions(loopline_settings INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

# loopline_compile_together(TARGET PATTERN): sources whose path gives the same first group of PATTERN are one translation
# unit, where CMAKE_UNITY_BUILD is on (the presets): headers and templates then cost once a group, which is half the time.
function(loopline_compile_together target pattern)
    set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
    get_target_property(sources ${target} SOURCES)
    foreach(source ${sources})
        file(RELATIVE_PATH path ${CMAKE_CURRENT_SOURCE_DIR} ${source})
        string(REGEX REPLACE "${pattern}" "\\1" group ${path})
        set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
    endforeach()
endfunction()

# loopline_precompile(TARGET): with LOOPLINE_PRECOMPILED_HEADERS what most sources begin with is read once, by loopline_api.
function(loopline_precompile target)
    if(NOT LOOPLINE_PRECOMPILED_HEADERS)
        return()
    endif()
    if(target STREQUAL loopline_api)
        target_precompile_headers(${target} PRIVATE <Eigen/Core> <Eigen/Geometry> <mrpt/obs/CObservation2DRangeScan.h>
            <mrpt/obs/CObservationGPS.h> <mrpt/obs/CObservationIMU.h> <mrpt/obs/CObservationOdometry.h>
            <mrpt/obs/CObservationRobotPose.h> <mrpt/obs/CSensoryFrame.h> <mrpt/serialization/CArchive.h> <algorithm> <array>
            <cmath> <deque> <filesystem> <fstream> <functional> <map> <memory> <optional> <set> <sstream> <string> <vector>)
    else()
        target_precompile_headers(${target} REUSE_FROM loopline_api)
    endif()
endfunction()

# loopline_library(NAME SOURCES... [LINK targets...]): what several plugins share, in each of them.
function(loopline_library name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
    add_library(loopline_${name} STATIC ${ARG_SOURCES})
    target_link_libraries(loopline_${name} PUBLIC loopline_settings ${ARG_LINK})
    target_include_directories(loopline_${name} PUBLIC ${PROJECT_SOURCE_DIR}/plugins)
    loopline_precompile(loopline_${name})
endfunction()

# loopline_plugin(NAME SOURCES... [LINK targets...]): a shared library that the host, and MRPT's own programs, load.
# "-z now": an unresolved symbol refuses the load with a message instead of ending the process later.
# "--no-as-needed": a library that only registers classes must stay in NEEDED.
function(loopline_plugin name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
    add_library(loopline_${name} SHARED ${ARG_SOURCES})
    target_link_libraries(loopline_${name} PUBLIC loopline_settings ${ARG_LINK})
    target_include_directories(loopline_${name} PUBLIC ${PROJECT_SOURCE_DIR}/plugins)
    target_link_options(loopline_${name} PRIVATE -Wl,-z,now -Wl,--no-undefined -Wl,--no-as-needed)
    set_target_properties(loopline_${name} PROPERTIES
        DEFINE_SYMBOL ""  # one more macro, and no compiler takes headers that were precompiled without it
        LIBRARY_OUTPUT_DIRECTORY ${LOOPLINE_PLUGIN_DIR}
        BUILD_RPATH "$ORIGIN" INSTALL_RPATH "$ORIGIN")
    loopline_precompile(loopline_${name})
    set_property(GLOBAL APPEND PROPERTY LOOPLINE_PLUGIN_TARGETS loopline_${name})
    install(TARGETS loopline_${name} LIBRARY DESTINATION lib/loopline)
endfunction()
