#include <cstdlib>
#include <systemc>

#include "test_session.h"

// The main of every test program that simulates. SystemC elaborates once in a process, so each test case that
// simulates runs in a process of its own (CTest sees to it).
int sc_main(int argc, char** argv) {
    // A warning of the model fails the test as its errors do: it reaches the caller of sc_start as an
    // exception. A test that provokes one gives the report's id actions of its own.
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_THROW);
    sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_THROW);
    return metabuffer::test::run_session(argc, argv);
}

int main(int argc, char** argv) {
    // The kernel's banner would appear among the names when the tests are listed.
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}
