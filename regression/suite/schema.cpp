#include "suite/schema.h"

#include <algorithm>
#include <fstream>
#include <numeric>
#include <regex>
#include <set>
#include <sstream>

#include "base/error.h"
#include "suite/schema_text.h"

namespace suite {
namespace {

using nlohmann::json;

// A value as a short quotation for an error line.
std::string quote(const json& value) {
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > 80) text = text.substr(0, 77) + "...";
  return text;
}

std::string list(const json& values) {
  std::string text;
  for (const json& value : values) text += (text.empty() ? "" : ", ") + value.dump();
  return text;
}

std::string number(const json& value) { return value.dump(); }

bool has_type(const json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  throw std::logic_error("schema: unknown type " + type);
}

class Checker {
 public:
  Checker(const std::string& file, const json& root) : file_(file), root_(root) {}

  void check(const json& value, const json& schema, const std::string& path) const {
    if (schema.contains("$ref")) return check(value, resolve(schema["$ref"]), path);
    if (schema.contains("oneOf")) return check(value, choose_branch(value, schema["oneOf"], path), path);
    check_type(value, schema, path);
    if (schema.contains("const") && value != schema["const"])
      wrong(path, quote(schema["const"]), quote(value));
    if (schema.contains("enum")) check_enum(value, schema["enum"], path);
    if (value.is_number()) check_range(value, schema, path);
    if (value.is_string()) check_string(value, schema, path);
    if (value.is_array()) check_array(value, schema, path);
    if (value.is_object()) check_object(value, schema, path);
  }

 private:
  [[noreturn]] void wrong(const std::string& path, const std::string& wanted,
                          const std::string& found) const {
    base::fail_in(file_, path.empty() ? "top level" : path, wanted, found);
  }

  const json& resolve(const std::string& reference) const {
    return root_.at(json::json_pointer(reference.substr(1)));
  }

  void check_type(const json& value, const json& schema, const std::string& path) const {
    if (!schema.contains("type")) return;
    const json types = schema["type"].is_array() ? schema["type"] : json::array({schema["type"]});
    const bool fits =
        std::any_of(types.begin(), types.end(), [&](const json& t) { return has_type(value, t); });
    if (fits) return;
    std::string wanted;
    for (const json& type : types) wanted += (wanted.empty() ? "" : " or ") + type.get<std::string>();
    wrong(path, (std::string("aeio").find(wanted[0]) != std::string::npos ? "an " : "a ") + wanted,
          quote(value));
  }

  void check_enum(const json& value, const json& choices, const std::string& path) const {
    if (std::find(choices.begin(), choices.end(), value) != choices.end()) return;
    wrong(path, "one of " + list(choices), quote(value));
  }

  void check_range(const json& value, const json& schema, const std::string& path) const {
    const double x = value.get<double>();
    const bool low = (schema.contains("minimum") && x < schema["minimum"].get<double>()) ||
                     (schema.contains("exclusiveMinimum") && x <= schema["exclusiveMinimum"].get<double>());
    const bool high = schema.contains("maximum") && x > schema["maximum"].get<double>();
    if (!low && !high) return;
    std::string wanted;
    if (schema.contains("minimum")) wanted += "at least " + number(schema["minimum"]);
    if (schema.contains("exclusiveMinimum")) wanted += "above " + number(schema["exclusiveMinimum"]);
    if (schema.contains("maximum"))
      wanted += (wanted.empty() ? "at most " : " and at most ") + number(schema["maximum"]);
    wrong(path, "a number " + wanted, quote(value));
  }

  void check_string(const json& value, const json& schema, const std::string& path) const {
    const std::string text = value;
    if (schema.contains("minLength") && text.size() < schema["minLength"].get<size_t>())
      wrong(path, "a text", "an empty string");
    if (schema.contains("pattern") &&
        !std::regex_search(text, std::regex(schema["pattern"].get<std::string>())))
      wrong(path, "a string like " + schema["pattern"].get<std::string>(), quote(value));
    if (schema.contains("not")) {
      const json& banned = schema["not"].at("enum");
      if (std::find(banned.begin(), banned.end(), value) != banned.end())
        wrong(path, "another key", quote(value));
    }
  }

  void check_array(const json& value, const json& schema, const std::string& path) const {
    const size_t least = schema.value("minItems", size_t{0}),
                 most = schema.value("maxItems", size_t{1} << 30);
    if (value.size() < least || value.size() > most)
      wrong(path, std::to_string(least) + (least == most ? "" : " or more") + " elements",
            std::to_string(value.size()));
    if (schema.contains("items"))
      for (size_t i = 0; i < value.size(); ++i)
        check(value[i], schema["items"], path + "[" + std::to_string(i) + "]");
  }

  void check_object(const json& value, const json& schema, const std::string& path) const {
    const json properties = schema.value("properties", json::object());
    for (const auto& [key, element] : value.items()) {
      const std::string place = path.empty() ? key : path + "." + key;
      if (schema.contains("propertyNames")) check_string(key, schema["propertyNames"], place);
      if (properties.contains(key)) {
        check(element, properties[key], place);
      } else if (schema.contains("additionalProperties")) {
        if (schema["additionalProperties"] == false) unknown_key(place, key, properties);
        check(element, schema["additionalProperties"], place);
      }
    }
    for (const json& key : schema.value("required", json::array()))
      if (!value.contains(key))
        wrong(path, "the key \"" + key.get<std::string>() + "\"",
              "only " + (value.empty() ? "{}" : keys(value)));
  }

  [[noreturn]] void unknown_key(const std::string& place, const std::string& key,
                                const json& properties) const {
    std::vector<std::string> known;
    for (const auto& [name, unused] : properties.items()) known.push_back(name);
    const std::string near = near_miss(key, known);
    wrong(place, near.empty() ? "one of " + keys(properties) : "a known key (did you mean \"" + near + "\"?)",
          "\"" + key + "\"");
  }

  static std::string keys(const json& object) {
    std::string text;
    for (const auto& [key, unused] : object.items()) text += (text.empty() ? "" : ", ") + key;
    return text;
  }

  // The branch whose const property the value has.
  const json& choose_branch(const json& value, const json& branches, const std::string& path) const {
    std::string tag;
    json choices = json::array();
    for (const json& branch : branches) {
      const json& schema = branch.contains("$ref") ? resolve(branch["$ref"]) : branch;
      for (const auto& [key, property] : schema["properties"].items()) {
        if (!property.contains("const")) continue;
        tag = key;
        choices.push_back(property["const"]);
        if (value.is_object() && value.contains(key) && value[key] == property["const"]) return schema;
      }
    }
    if (!value.is_object()) wrong(path, "an object", quote(value));
    if (!value.contains(tag)) wrong(path, "the key \"" + tag + "\"", "only " + keys(value));
    wrong(path + "." + tag, "one of " + list(choices), quote(value[tag]));
  }

  const std::string& file_;
  const json& root_;
};

// Refuses a key that stands twice in one object: the parser alone would keep the last without a word.
class Duplicates {
 public:
  explicit Duplicates(const std::string& file) : file_(file) {}
  bool operator()(int, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) seen_.emplace_back();
    if (event == json::parse_event_t::object_end) seen_.pop_back();
    if (event == json::parse_event_t::key && !seen_.back().insert(parsed.get<std::string>()).second)
      base::fail_in(file_, parsed.get<std::string>(), "each key once", "it twice");
    return true;
  }

 private:
  const std::string& file_;
  std::vector<std::set<std::string>> seen_;
};

}  // namespace

const json& case_schema() {
  static const json schema = json::parse(schema_text);
  return schema;
}

json read_json(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) base::fail_in(file, "", "a readable JSON file", "none");
  std::ostringstream text;
  text << stream.rdbuf();
  try {
    auto duplicates = std::make_shared<Duplicates>(file);
    return json::parse(text.str(), [duplicates](int depth, json::parse_event_t event, json& parsed) {
      return (*duplicates)(depth, event, parsed);
    });
  } catch (const json::exception& error) {
    std::string what = error.what();
    const size_t bracket = what.find("] ");
    base::fail(file,
               ": wanted JSON, found: ", bracket == std::string::npos ? what : what.substr(bracket + 2));
  }
}

void check_schema(const std::string& file, const json& value, const json& schema) {
  Checker(file, schema).check(value, schema, "");
}

std::string near_miss(const std::string& word, const std::vector<std::string>& words) {
  std::string best;
  size_t best_distance = std::max<size_t>(2, word.size() / 3) + 1;
  for (const std::string& other : words) {
    // Levenshtein distance, one row at a time.
    std::vector<size_t> row(other.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 0; i < word.size(); ++i) {
      size_t diagonal = row[0]++;
      for (size_t j = 0; j < other.size(); ++j) {
        const size_t substituted = diagonal + (word[i] != other[j]);
        diagonal = row[j + 1];
        row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
      }
    }
    if (row.back() < best_distance) best_distance = row.back(), best = other;
  }
  return best;
}

}  // namespace suite
