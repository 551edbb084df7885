# A plugin of the tests' own, kept out of the folder that the program searches.
add_library(restirpg-pass-FixedGuide MODULE guide/FixedGuide/FixedGuide.cpp)
target_link_libraries(restirpg-pass-FixedGuide PRIVATE restirpg)
target_compile_definitions(restirpg-pass-FixedGuide PRIVATE RESTIRPG_PASS_FOLDER="${CMAKE_CURRENT_SOURCE_DIR}/guide/FixedGuide")
set_target_properties(restirpg-pass-FixedGuide PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests/passes)
restirpg_test(screen_lobe_test
    SOURCES guide/screen_lobe_test.cpp
    LINKS restirpg_core restirpg_gpu)
