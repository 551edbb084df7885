restirpg_test(accumulate_test SOURCES passes/accumulate_test.cpp LINKS restirpg)
add_dependencies(accumulate_test restirpg-pass-Accumulate)
restirpg_test(error_measure_test SOURCES passes/error_measure_test.cpp LINKS restirpg)
add_dependencies(error_measure_test restirpg-pass-ErrorMeasure)
