# cmake -DOUTPUT=x.cpp -DROOT=dir -DFILES=a;b -DFUNCTION=name -P embed_text.cmake
# Writes a C++ file with std::span<const tessera::EmbeddedText> <FUNCTION>() over the named files' text.
set(body "#include \"engine/core/embedded.hpp\"\n\nnamespace tessera {\nnamespace {\n")
set(table "")
set(index 0)
foreach(file IN LISTS FILES)
  file(READ "${ROOT}/${file}" hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(APPEND body "const unsigned char text${index}[] = {${bytes}0x00};\n")
  string(APPEND table "    {\"${file}\", {reinterpret_cast<const char*>(text${index}), sizeof(text${index}) - 1}},\n")
  math(EXPR index "${index} + 1")
endforeach()
string(APPEND body "const EmbeddedText kTable[] = {\n${table}};\n}  // namespace\n\n"
                   "std::span<const EmbeddedText> ${FUNCTION}() { return kTable; }\n}  // namespace tessera\n")
file(WRITE "${OUTPUT}" "${body}")
