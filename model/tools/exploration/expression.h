#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// A formula over named values, in the syntax of SQL expressions: `bus.width_bits >= 64 and bus.arbitration <> 'edf'`.
/// Names are scenario keys or figures of a run, written plainly or in double quotes; texts are in single quotes.
/// Operators and functions are those of SQLite that depend on nothing but their operands: there are no subqueries,
/// tables or files. Evaluated by SQLite.
class Expression {
  public:
    /// `names` may appear in it; `where` begins the message of an error. Throws InputError if the text is not an
    /// expression, or if it has an unknown name; the message then says the nearest known one.
    Expression(const std::string& text, const std::vector<std::string>& names, const std::string& where);
    Expression(Expression&&) noexcept;
    Expression& operator=(Expression&&) noexcept;
    ~Expression();

    const std::string& text() const;
    /// The names that it uses, each once.
    const std::vector<std::string>& names() const;
    bool uses(const std::string& name) const;
    /// Its value, given those of its names. Throws InputError if it has none for these (say, abs() of the least
    /// whole number).
    Value evaluate(const std::function<Value(const std::string& name)>& value_of_name) const;
    /// Whether its value is true: neither nothing nor zero. Throws InputError for a text, which is neither true nor
    /// false.
    bool holds(const std::function<Value(const std::string& name)>& value_of_name) const;

  private:
    struct Statement;
    std::unique_ptr<Statement> statement_;
};

/// `text`, checked as by Expression, with every name in double quotes: an expression for an SQL statement over columns
/// of these names. Throws InputError; `where` begins its message.
std::string sql_expression(const std::string& text, const std::vector<std::string>& names,
                           const std::string& where);

/// The expressions of a list with commas in between, unchecked. Commas in parentheses and quotes do not divide.
std::vector<std::string> split_expressions(const std::string& text);

/// The parts of a condition that `and` joins, unchecked: `between 1 and 2` is divided as well.
std::vector<std::string> conjuncts(const std::string& text);

/// The name in double quotes, so that SQL accepts it with any characters.
std::string quoted_name(const std::string& name);

/// The functions that an expression may use, in alphabetical order.
const std::vector<std::string>& expression_functions();

}  // namespace metabuffer::exploration
