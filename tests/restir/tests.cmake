# A plugin of the tests' own, kept out of the folder that the program searches.
add_library(restirpg-pass-MergeProbe MODULE restir/MergeProbe/MergeProbe.cpp)
target_link_libraries(restirpg-pass-MergeProbe PRIVATE restirpg)
target_compile_definitions(restirpg-pass-MergeProbe PRIVATE
    RESTIRPG_PASS_FOLDER="${CMAKE_CURRENT_SOURCE_DIR}/restir/MergeProbe")
set_target_properties(restirpg-pass-MergeProbe PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests/passes)
