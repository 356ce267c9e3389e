#include <cstdlib>

namespace {

struct Crashing {
    Crashing() { std::abort(); }
};

const Crashing crashing;

}  // namespace
