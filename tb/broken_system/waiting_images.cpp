#include <unistd.h>

namespace {

struct Waiting {
    Waiting() {
        for (;;) pause();
    }
};

const Waiting waiting;

}  // namespace
