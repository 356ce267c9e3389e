#include "tools/exploration/expression.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <sqlite3.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <functional>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "host/errors.h"
#include "host/text.h"
#include "tools/exploration/sqlite_value.h"

namespace metabuffer::exploration {

namespace {

constexpr std::size_t kLongestText = 10'000;
constexpr int kLongestComputedValueBytes = 1'000'000;
/// SQLite's parser gives up at about a hundred, with a message of its own.
constexpr int kDeepestParentheses = 50;

/// The words of SQL that make expressions. FROM is there for IS DISTINCT FROM: anywhere else SQLite refuses it.
constexpr std::array<std::string_view, 29> kWords{
    "and",     "as",   "between", "case", "cast", "collate", "distinct", "else", "end",    "escape",
    "false",   "from", "glob",    "in",   "is",   "integer", "isnull",   "like", "nocase", "not",
    "notnull", "null", "numeric", "or",   "real", "text",    "then",     "true", "when"};
/// The words that make a subquery, to distinguish them from misspelt names.
constexpr std::array<std::string_view, 4> kQueryWords{"exists", "select", "values", "with"};

constexpr std::string_view kOperators = "+-*/%<>=!~&|,";

bool is_space(char character) { return std::isspace(static_cast<unsigned char>(character)) != 0; }

bool is_digit(char character) { return std::isdigit(static_cast<unsigned char>(character)) != 0; }

bool begins_name(char character) {
    const auto code = static_cast<unsigned char>(character);
    return std::isalpha(code) != 0 || character == '_' || code >= 0x80U;
}

bool continues_name(char character) { return begins_name(character) || is_digit(character); }

std::string trimmed(const std::string& text) {
    const auto begin = std::find_if_not(text.begin(), text.end(), is_space);
    return {begin, std::find_if_not(text.rbegin(), std::make_reverse_iterator(begin), is_space).base()};
}

std::string lower_case(std::string_view word) {
    std::string result(word);
    std::transform(result.begin(), result.end(), result.begin(),
                   [](unsigned char character) { return static_cast<char>(std::tolower(character)); });
    return result;
}

template <typename List, typename Item>
bool contains(const List& list, const Item& item) {
    return std::find(list.begin(), list.end(), item) != list.end();
}

/// Goes through an expression from left to right and finds the names. Besides names it accepts only punctuation,
/// numbers, texts, known functions and the words of SQL that make expressions. Whatever SQLite makes of these, they
/// reach no tables or files.
class Scanner {
  public:
    using WriteName = std::function<std::string(const std::string& name)>;

    Scanner(std::string_view text, const std::vector<std::string>& names, const std::string& where,
            WriteName write_name)
        : text_(text), names_(names), where_(where), write_name_(std::move(write_name)) {}

    /// The text with its names as write_name writes them.
    std::string scan() {
        if (text_.size() > kLongestText) {
            fail("the expression has " + std::to_string(text_.size()) + " characters; use at most " +
                 std::to_string(kLongestText));
        }
        if (text::one_line(text_).empty()) fail("there is no expression");
        while (position_ < text_.size()) take_token();
        if (depth_ > 0) fail("a parenthesis is not closed");
        return std::move(result_);
    }

  private:
    [[noreturn]] void fail(const std::string& message) const {
        throw InputError(text::located(where_, message));
    }

    char at(std::size_t position) const { return position < text_.size() ? text_[position] : '\0'; }

    void take_token() {
        const char character = at(position_);
        if (character == '\'') return copy_to(end_of_quoted('\''));
        if (character == '"') return take_quoted_name();
        if (is_digit(character) || (character == '.' && is_digit(at(position_ + 1)))) return take_number();
        if (begins_name(character)) return take_name_or_word();
        take_punctuation();
    }

    /// The end of the quoted text that begins at position_; a doubled quote does not end it.
    std::size_t end_of_quoted(char quote) const {
        std::size_t end = position_ + 1;
        while (end < text_.size()) {
            if (at(end) == '\0') fail("a text cannot hold a character of value zero");
            if (at(end) == quote) {
                if (at(end + 1) != quote) return end + 1;
                ++end;
            }
            ++end;
        }
        fail(std::string("a ") + quote + " is not closed");
    }

    void take_quoted_name() {
        const std::size_t end = end_of_quoted('"');
        std::string name;
        for (std::size_t n = position_ + 1; n + 1 < end; ++n) {
            name += at(n);
            if (at(n) == '"') ++n;
        }
        if (!contains(names_, name)) fail_unknown(name, true);
        result_ += write_name_(name);
        position_ = end;
    }

    void take_number() {
        std::size_t end = position_;
        while (is_digit(at(end)) || at(end) == '.') ++end;
        const std::size_t digits = at(end + 1) == '+' || at(end + 1) == '-' ? end + 2 : end + 1;
        if ((at(end) == 'e' || at(end) == 'E') && is_digit(at(digits))) {
            end = digits;
            while (is_digit(at(end))) ++end;
        }
        if (continues_name(at(end))) {
            while (continues_name(at(end)) || at(end) == '.') ++end;
            fail(text::quoted(text_.substr(position_, end - position_)) + " is neither a number nor a name");
        }
        copy_to(end);
    }

    /// Whether a name that begins at position_ may end at `end`: what follows must not belong to it.
    bool is_whole(std::size_t end) const {
        return !continues_name(at(end)) && !(at(end) == '.' && continues_name(at(end + 1)));
    }

    void take_name_or_word() {
        const std::string* longest = nullptr;
        for (const std::string& name : names_) {
            if (text_.compare(position_, name.size(), name) == 0 && is_whole(position_ + name.size()) &&
                (longest == nullptr || name.size() > longest->size())) {
                longest = &name;
            }
        }
        if (longest != nullptr && !longest->empty()) {
            result_ += write_name_(*longest);
            position_ += longest->size();
            return;
        }
        take_word();
    }

    void take_word() {
        std::size_t end = position_;
        while (!is_whole(end)) ++end;
        const std::string word(text_.substr(position_, end - position_));
        const std::string lower = lower_case(word);
        std::size_t behind = end;
        while (is_space(at(behind))) ++behind;
        if (contains(kQueryWords, lower)) fail(text::quoted(word) + ": an expression cannot hold a query");
        if (!contains(kWords, lower)) {
            if (at(behind) != '(') fail_unknown(word, false);
            if (!contains(expression_functions(), lower)) fail_unknown_function(word);
        }
        copy_to(end);
    }

    void take_punctuation() {
        const char character = at(position_);
        const char next = at(position_ + 1);
        if ((character == '-' && next == '-') || (character == '/' && next == '*')) {
            fail(std::string("'") + character + next + "' would begin a comment; put a space in between");
        }
        if (character == '(' && ++depth_ > kDeepestParentheses) {
            fail("parentheses are nested deeper than " + std::to_string(kDeepestParentheses));
        }
        if (character == ')' && --depth_ < 0) fail("a parenthesis is closed that is not open");
        if (character == ',' && depth_ == 0)
            fail("a comma stands outside of parentheses; use one expression");
        if (character != '(' && character != ')' && !is_space(character) &&
            kOperators.find(character) == std::string_view::npos) {
            fail(text::quoted(std::string(1, character)) + " has no place in an expression");
        }
        copy_to(position_ + 1);
    }

    void copy_to(std::size_t end) {
        result_ += text_.substr(position_, end - position_);
        position_ = end;
    }

    [[noreturn]] void fail_unknown(const std::string& word, bool is_quoted) const {
        std::string message = text::quoted(word) + " is not known";
        const std::string nearest = names_.empty() ? "" : text::nearest(word, names_);
        if (!names_.empty()) message += "; the nearest is " + nearest;
        constexpr int kMisspelt = 2;
        const bool is_misspelt = !names_.empty() && text::edit_distance(word, nearest) <= kMisspelt;
        if (is_quoted || (!is_misspelt && word.find('.') == std::string::npos)) {
            message += "; if it is a text, write " + text::quoted(word);
        }
        fail(message);
    }

    [[noreturn]] void fail_unknown_function(const std::string& word) const {
        fail(text::quoted(word) + " is no function that can be used here; the nearest is " +
             text::nearest(lower_case(word), expression_functions()) + "()");
    }

    std::string_view text_;
    const std::vector<std::string>& names_;
    const std::string& where_;
    WriteName write_name_;
    std::size_t position_ = 0;
    int depth_ = 0;
    std::string result_;
};

/// The second line of defence, after the scanner: SQLite may use expressions and known functions, and nothing else.
int authorize(void* /*unused*/, int action, const char* /*unused*/, const char* function,
              const char* /*unused*/, const char* /*unused*/) {
    if (action == SQLITE_SELECT) return SQLITE_OK;
    if (action != SQLITE_FUNCTION || function == nullptr) return SQLITE_DENY;
    const std::string name = lower_case(function);
    const bool is_operator = name == "like" || name == "glob";
    return is_operator || contains(expression_functions(), name) ? SQLITE_OK : SQLITE_DENY;
}

SQLite::Database expression_database() {
    SQLite::Database database(":memory:", SQLite::OPEN_READONLY);
    sqlite3* const handle = database.getHandle();
    sqlite3_set_authorizer(handle, authorize, nullptr);
    sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, kLongestComputedValueBytes);
    sqlite3_limit(handle, SQLITE_LIMIT_ATTACHED, 0);
    return database;
}

/// SQLite's message with names instead of its parameters.
std::string plain_message(const SQLite::Exception& error, const std::vector<std::string>& names) {
    std::string message = error.what();
    for (std::size_t n = names.size(); n > 0; --n) {
        const std::string parameter = "?" + std::to_string(n);
        const std::size_t position = message.find(parameter);
        if (position != std::string::npos) message.replace(position, parameter.size(), names[n - 1]);
    }
    return message;
}

}  // namespace

struct Expression::Statement {
    Statement(std::string text_in, const std::vector<std::string>& known, std::string where_in)
        : text(std::move(text_in)), where(std::move(where_in)), database(expression_database()) {
        const std::string sql = Scanner(text, known, where, [this](const std::string& name) {
                                    auto position = std::find(names.begin(), names.end(), name);
                                    if (position == names.end()) position = names.insert(position, name);
                                    return "?" + std::to_string(position - names.begin() + 1);
                                }).scan();
        try {
            // A condition, unlike a column, can neither be named (`a b` is `a AS b`) nor count rows.
            const SQLite::Statement condition(database, "SELECT 1 WHERE " + sql);
            query.emplace(database, "SELECT (" + sql + ")");
        } catch (const SQLite::Exception& error) {
            fail(text::quoted(text) + " is no expression: " + plain_message(error, names));
        }
    }

    [[noreturn]] void fail(const std::string& message) const {
        throw InputError(text::located(where, message));
    }

    std::string text;
    std::string where;
    std::vector<std::string> names;  ///< name n is parameter n + 1
    SQLite::Database database;
    std::optional<SQLite::Statement> query;  ///< destroyed before its database
};

Expression::Expression(const std::string& text, const std::vector<std::string>& names,
                       const std::string& where)
    : statement_(std::make_unique<Statement>(text, names, where)) {}
Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;
Expression::~Expression() = default;

const std::string& Expression::text() const { return statement_->text; }

const std::vector<std::string>& Expression::names() const { return statement_->names; }

bool Expression::uses(const std::string& name) const {
    return std::find(names().begin(), names().end(), name) != names().end();
}

Value Expression::evaluate(const std::function<Value(const std::string& name)>& value_of_name) const {
    SQLite::Statement& query = *statement_->query;
    const StatementReset reset(query);
    try {
        int parameter = 0;
        for (const std::string& name : statement_->names) bind_value(query, ++parameter, value_of_name(name));
        query.executeStep();
        return value_of(query.getColumn(0));
    } catch (const SQLite::Exception& error) {
        statement_->fail(text::quoted(statement_->text) + " has no value: " + error.what());
    }
}

bool Expression::holds(const std::function<Value(const std::string& name)>& value_of_name) const {
    const Value value = evaluate(value_of_name);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return *whole != 0;
    if (const auto* number = std::get_if<double>(&value)) return *number != 0.0;
    if (const auto* words = std::get_if<std::string>(&value)) {
        statement_->fail(text::quoted(statement_->text) + " is the text " + text::quoted(*words) +
                         ", neither true nor false; use a comparison");
    }
    return false;
}

std::string sql_expression(const std::string& text, const std::vector<std::string>& names,
                           const std::string& where) {
    const Expression checked(text, names, where);
    return Scanner(text, names, where, quoted_name).scan();
}

namespace {

/// The parts between the separators that lie outside of parentheses and quotes. `separator_at` gives the length of the
/// separator that begins at an index, 0 if none does.
std::vector<std::string> split_outside(const std::string& text,
                                       const std::function<std::size_t(std::size_t)>& separator_at) {
    std::vector<std::string> parts(1);
    int depth = 0;
    char quote = '\0';
    for (std::size_t n = 0; n < text.size(); ++n) {
        const char character = text[n];
        if (quote != '\0') {
            // A doubled quote closes and opens again, which makes no difference here.
            if (character == quote) quote = '\0';
        } else if (character == '\'' || character == '"') {
            quote = character;
        } else if (character == '(') {
            ++depth;
        } else if (character == ')') {
            --depth;
        } else if (depth <= 0) {
            if (const std::size_t length = separator_at(n); length > 0) {
                parts.emplace_back();
                n += length - 1;
                continue;
            }
        }
        parts.back() += character;
    }
    std::transform(parts.begin(), parts.end(), parts.begin(), trimmed);
    return parts;
}

}  // namespace

std::vector<std::string> split_expressions(const std::string& text) {
    return split_outside(text, [&text](std::size_t n) -> std::size_t { return text[n] == ',' ? 1 : 0; });
}

std::vector<std::string> conjuncts(const std::string& text) {
    const auto is_letter = [&text](std::size_t n) {
        return n < text.size() && (std::isalnum(static_cast<unsigned char>(text[n])) != 0 || text[n] == '_');
    };
    const auto split_at = [&](const std::string& word) {
        return split_outside(text, [&](std::size_t n) -> std::size_t {
            const bool is_word = (n == 0 || !is_letter(n - 1)) && !is_letter(n + word.size());
            return is_word && strncasecmp(text.c_str() + n, word.c_str(), word.size()) == 0 ? word.size() : 0;
        });
    };
    if (split_at("or").size() > 1) return {text};
    std::vector<std::string> parts;
    for (const std::string& part : split_at("and")) {
        // Within an outer pair of parentheses nothing divides, so all of it is one part.
        const std::size_t end = part.size() - 1;
        const bool is_enclosed =
            part.size() > 2 && part.front() == '(' && part.back() == ')' &&
            split_outside(part, [end](std::size_t n) { return std::size_t{n > 0 && n < end}; }).size() == 1;
        if (!is_enclosed) {
            parts.push_back(part);
            continue;
        }
        for (std::string& inner : conjuncts(part.substr(1, part.size() - 2)))
            parts.push_back(std::move(inner));
    }
    return parts;
}

std::string quoted_name(const std::string& name) { return text::literal(name, '"'); }

const std::vector<std::string>& expression_functions() {
    static const std::vector<std::string> functions{
        "abs",     "ceil",  "coalesce", "exp",   "floor",  "ifnull", "iif",   "instr",  "length",
        "ln",      "log10", "log2",     "lower", "max",    "min",    "mod",   "nullif", "pow",
        "replace", "round", "sign",     "sqrt",  "substr", "trim",   "trunc", "typeof", "upper"};
    return functions;
}

}  // namespace metabuffer::exploration
