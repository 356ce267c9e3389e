#pragma once

namespace metabuffer::test {

/// A block that replaces the composer or its FIFO does not smooth: no test has a machine that does. It says so in
/// metabuffer_replace().
#ifdef METABUFFER_REPLICATES_ONLY
constexpr bool kReplicatesOnly = true;
#else
constexpr bool kReplicatesOnly = false;
#endif

}  // namespace metabuffer::test
