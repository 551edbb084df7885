# Plugins of the tests' own, kept out of the folder that the program searches.
foreach(name FixedGuide HeldGuide KnownSamples ReplayReuse)
    add_library(restirpg-pass-${name} MODULE guide/${name}/${name}.cpp)
    target_link_libraries(restirpg-pass-${name} PRIVATE restirpg)
    target_compile_definitions(restirpg-pass-${name} PRIVATE
        RESTIRPG_PASS_FOLDER="${CMAKE_CURRENT_SOURCE_DIR}/guide/${name}" RESTIRPG_PASSES="${PROJECT_SOURCE_DIR}/passes")
    set_target_properties(restirpg-pass-${name} PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests/passes)
endforeach()
restirpg_test(screen_lobe_test
    SOURCES guide/screen_lobe_test.cpp
    LINKS restirpg_core restirpg_gpu)
restirpg_test(grid_guide_test
    SOURCES guide/grid_guide_test.cpp
    LINKS restirpg_core restirpg_gpu)
