#pragma once

#include <stdexcept>

namespace metabuffer {

/// A result that cannot be written. what() is one line.
class OutputError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace metabuffer
