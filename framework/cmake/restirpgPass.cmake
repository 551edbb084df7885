# restirpg_add_pass(Name [SOURCES ...]): build Name.cpp in the current folder as the plugin restirpg-pass-Name.so.
# Shaders are read at run time from the folder of the source, or from where restirpg_install_pass puts them.
function(restirpg_add_pass name)
    cmake_parse_arguments(PARSE_ARGV 1 pass "" "" "SOURCES")
    if(NOT pass_SOURCES)
        set(pass_SOURCES ${name}.cpp)
    endif()
    add_library(restirpg-pass-${name} MODULE ${pass_SOURCES})
    if(TARGET restirpg::restirpg)
        target_link_libraries(restirpg-pass-${name} PRIVATE restirpg::restirpg)
    else()
        target_link_libraries(restirpg-pass-${name} PRIVATE restirpg)
        set_target_properties(restirpg-pass-${name} PROPERTIES
            LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/restirpg/passes)
    endif()
    set_target_properties(restirpg-pass-${name} PROPERTIES PREFIX "")
    target_include_directories(restirpg-pass-${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
    target_compile_definitions(restirpg-pass-${name} PRIVATE RESTIRPG_PASS_FOLDER="${CMAKE_CURRENT_SOURCE_DIR}")
endfunction()
