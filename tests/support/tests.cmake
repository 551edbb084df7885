restirpg_test(statistics_test SOURCES support/statistics_test.cpp)
