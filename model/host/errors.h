#pragma once

#include <stdexcept>

namespace metabuffer {

/// Bad input of any kind. what() is one line: where (file:line), what is wrong, what would be right.
class InputError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A result that cannot be written. what() is one line.
class OutputError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace metabuffer
