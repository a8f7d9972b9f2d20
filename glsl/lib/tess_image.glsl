// The atlas as an image, for gatherers that store their texels.
layout(binding = 0) writeonly uniform image2D uAtlasImage;
void storeSample(uint entry, Sample s) {
  if (s.used) imageStore(uAtlasImage, ivec2(s.texel), atlasValue(shadePlace(entry, s.at)));
}
