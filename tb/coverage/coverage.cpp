#include "coverage.h"

namespace metabuffer::coverage {

void Coverage::add(const Coverage& other) {
    for (std::size_t goal = 0; goal < counts_.size(); ++goal) counts_[goal] += other.counts_[goal];
}

}  // namespace metabuffer::coverage
