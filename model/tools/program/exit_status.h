#pragma once

namespace metabuffer {

/// The exit status of the program.
enum ExitStatus : int {
    kExitDone = 0,
    kExitModelError = 1,  ///< a block found its protocol broken: a bug in the model
    kExitBadInput =
        2,  ///< scenario, images, command line, an event that does not happen, or an output that cannot be written
    kExitStrict = 3,      ///< --strict, and something starved or was rejected, or a point has no result
    kExitWatchdog = 4,    ///< nothing moved any more (compare: 0 instead if both levels agree on that)
    kExitDifferent = 5,   ///< compare: the levels differ; run --check: the level breaks a rule
    kExitIncomplete = 6,  ///< merge: points of the sweep are missing
    kExitStopped = 130,   ///< sweep and size: stopped by Ctrl-C; shells use this number
};

}  // namespace metabuffer
