# Compiler settings and the two kinds of target that Loopline builds: plugin libraries and test programs.

add_library(loopline_settings INTERFACE)
target_compile_options(loopline_settings INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor)
# Bit-equal results on every build: no contraction of a*b+c that one compiler does and another does not.
target_compile_options(loopline_settings INTERFACE -ffp-contract=off)
if(LOOPLINE_SANITIZE)
    # The product has both. Of the tests' own code, which is half of all code and takes twice as long to compile with
    # both, only memory is watched.
    set(product $<NOT:$<BOOL:$<TARGET_PROPERTY:LOOPLINE_TEST_CODE>>>)
    target_compile_options(loopline_settings INTERFACE -fsanitize=address -fno-omit-frame-pointer
        $<${product}:-fsanitize=undefined> $<${product}:-fno-sanitize-recover=undefined>)
    target_link_options(loopline_settings INTERFACE -fsanitize=address,undefined)
endif()

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
        LIBRARY_OUTPUT_DIRECTORY ${LOOPLINE_PLUGIN_DIR}
        BUILD_RPATH "$ORIGIN" INSTALL_RPATH "$ORIGIN")
    set_property(GLOBAL APPEND PROPERTY LOOPLINE_PLUGIN_TARGETS loopline_${name})
    set_property(GLOBAL APPEND PROPERTY LOOPLINE_PLUGIN_TARGETS loopline_${name})
    install(TARGETS loopline_${name} LIBRARY DESTINATION lib/loopline)
endfunction()
