#pragma once

#include <memory>
#include <vector>

#include "report/composer_record.h"

namespace metabuffer::test {

/// The record of a composer whose part is tested alone.
struct Record final : ComposerRecord {};

/// What each of a Lockstep's blocks records. A base class that comes before Lockstep, since the blocks are made before
/// any member is.
struct Records {
    std::vector<std::unique_ptr<Record>> records_;
};

}  // namespace metabuffer::test
