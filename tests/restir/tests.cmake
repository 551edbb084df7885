# Plugins of the tests' own, kept out of the folder that the program searches.
foreach(pass MergeProbe ShiftProbe)
    add_library(restirpg-pass-${pass} MODULE restir/${pass}/${pass}.cpp)
    target_link_libraries(restirpg-pass-${pass} PRIVATE restirpg)
    target_compile_definitions(restirpg-pass-${pass} PRIVATE
        RESTIRPG_PASS_FOLDER="${CMAKE_CURRENT_SOURCE_DIR}/restir/${pass}")
    set_target_properties(restirpg-pass-${pass} PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests/passes)
endforeach()
