// What was built.
#pragma once

namespace restirpg {

/// That of the project in CMakeLists.txt.
extern const char* const VERSION;

/// The commit the library was built from, with "+" when files differed from it; "unknown" outside a git checkout.
extern const char* const COMMIT;

}  // namespace restirpg
