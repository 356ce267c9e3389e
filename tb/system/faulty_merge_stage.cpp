#include "datapath/composition.h"

// Replaces the merge stage of level rtl in a separate program, so that `metabuffer run --check` has something to find: at
// equal Z its local pixel wins, where the one from upstream should.

namespace metabuffer {

/// A tie goes the wrong way. Everything else is as in the merge stage itself.
constexpr Pixel compose_wrongly(Composition composition, Pixel local, Pixel upstream) {
    return local.z() == upstream.z() ? local : compose(composition, local, upstream);
}

}  // namespace metabuffer

#define compose \
    compose_wrongly  // NOLINT(cppcoreguidelines-macro-usage): the very source, but for one function
// NOLINTNEXTLINE(bugprone-suspicious-include)
#include "rtl/merge_stage.cpp"
