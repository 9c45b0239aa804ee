#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imslam::report {

/// `text` for use between tags and in quoted attributes. Control characters, which HTML forbids,
/// and bytes that are not UTF-8 become U+FFFD.
std::string escape_html(std::string_view text);

/// JSON for a data script: nothing in it can end the script element or open a comment.
std::string escape_json_for_script(std::string_view json);

/// RFC 4648, padded.
std::string base64(const void* bytes, std::size_t size);

/// Little-endian array of `Number` in base64, as JavaScript's typed arrays read it.
template <typename Number>
std::string base64(const std::vector<Number>& values) {
  return base64(values.data(), values.size() * sizeof(Number));
}

/// The source expression ('sha256-...') that lets an inline script or style pass a content
/// security policy.
std::string csp_hash(std::string_view inline_text);

/// Replaces each {{name}} in one pass, so that inserted text is never looked at again. Throws
/// ContractError for a name without a value.
std::string fill_template(std::string_view text,
                          const std::vector<std::pair<std::string, std::string>>& values);

}  // namespace imslam::report
