# Write render/version.cpp with the version VERSION and the commit at hand; touched only when it changes. Run at every build.
cmake_minimum_required(VERSION 3.25)  # sets the policies: this file is run as a script
execute_process(COMMAND git -C ${SOURCE} rev-parse --show-toplevel
    OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(REAL_PATH ${SOURCE} source)
if(top STREQUAL source)  # sources that lie unpacked in another project's repository are not of its commit
    execute_process(COMMAND git -C ${SOURCE} describe --always --dirty=+ --abbrev=10 --exclude=*
        OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT commit)
    set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT
"#include \"render/version.h\"

namespace restirpg {

const char* const VERSION = \"@VERSION@\";
const char* const COMMIT = \"@commit@\";

}  // namespace restirpg
")
