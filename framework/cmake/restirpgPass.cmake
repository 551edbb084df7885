# restirpg_add_pass(Name [SOURCES ...]): build Name.cpp of the current folder as the plugin restirpg-pass-Name.so.
# The same call serves in this repository and, after find_package(restirpg), in any other.
# Kernels are read at run time: from the current source folder, or, after `cmake --install`, from the folder
# restirpg-pass-Name beside the plugin (passFile of graph/pass.h finds them).
function(restirpg_add_pass name)
    cmake_parse_arguments(PARSE_ARGV 1 pass "" "" "SOURCES")
    if(NOT pass_SOURCES)
        set(pass_SOURCES ${name}.cpp)
    endif()
    set(target restirpg-pass-${name})
    add_library(${target} MODULE ${pass_SOURCES})
    set_target_properties(${target} PROPERTIES PREFIX "" CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON)
    target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
    # As seen from the library, so that a tree that is moved with its sources goes on.
    file(REAL_PATH ${CMAKE_CURRENT_SOURCE_DIR} source_folder)
    target_compile_definitions(${target} PRIVATE
        RESTIRPG_PASS_FOLDER="$<PATH:RELATIVE_PATH,${source_folder},$<TARGET_FILE_DIR:${target}>>")
    if(TARGET restirpg::restirpg)
        target_link_libraries(${target} PRIVATE restirpg::restirpg)
    else()
        target_link_libraries(${target} PRIVATE restirpg)
        set_target_properties(${target} PROPERTIES
            LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/restirpg/passes INSTALL_RPATH "$ORIGIN/../..")
        add_dependencies(renderer ${target})
        target_precompile_headers(${target} REUSE_FROM restirpg_core)
    endif()
    install(TARGETS ${target} LIBRARY DESTINATION lib/restirpg/passes)
    install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION lib/restirpg/passes/${target}
        FILES_MATCHING PATTERN "*.comp" PATTERN "*.glsl" PATTERN "*.h")
endfunction()
