#pragma once

namespace metabuffer::test {

/// Runs the test cases that the arguments select, as every test program does. How many failed, for the exit status.
int run_session(int argc, const char* const* argv);

}  // namespace metabuffer::test
