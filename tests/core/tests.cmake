restirpg_test(core_test SOURCES core/error_test.cpp core/log_test.cpp core/memory_test.cpp LINKS restirpg_core)
