#include "test_session.h"

// The main of every test program that does not simulate.
int main(int argc, char** argv) { return metabuffer::test::run_session(argc, argv); }
