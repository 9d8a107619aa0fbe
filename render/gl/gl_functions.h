#pragma once

#include <GL/glcorearb.h>

#include <functional>
#include <string>

#include "sim/base/result.h"

/// Every OpenGL function that is used, as X(type suffix, name without gl).
#define WRY_GL_FUNCTIONS(X)                                                                                            \
  X(ATTACHSHADER, AttachShader)                                                                                        \
  X(BINDFRAMEBUFFER, BindFramebuffer)                                                                                  \
  X(BINDSAMPLER, BindSampler)                                                                                          \
  X(BINDTEXTUREUNIT, BindTextureUnit)                                                                                  \
  X(BINDVERTEXARRAY, BindVertexArray)                                                                                  \
  X(BLENDFUNC, BlendFunc)                                                                                              \
  X(CHECKNAMEDFRAMEBUFFERSTATUS, CheckNamedFramebufferStatus)                                                          \
  X(CLEARNAMEDFRAMEBUFFERFV, ClearNamedFramebufferfv)                                                                  \
  X(CLEARNAMEDFRAMEBUFFERUIV, ClearNamedFramebufferuiv)                                                                \
  X(CLIPCONTROL, ClipControl)                                                                                          \
  X(COMPILESHADER, CompileShader)                                                                                      \
  X(CREATEBUFFERS, CreateBuffers)                                                                                      \
  X(CREATEFRAMEBUFFERS, CreateFramebuffers)                                                                            \
  X(CREATEPROGRAM, CreateProgram)                                                                                      \
  X(CREATESAMPLERS, CreateSamplers)                                                                                    \
  X(CREATESHADER, CreateShader)                                                                                        \
  X(CREATETEXTURES, CreateTextures)                                                                                    \
  X(CREATEVERTEXARRAYS, CreateVertexArrays)                                                                            \
  X(CULLFACE, CullFace)                                                                                                \
  X(DELETEBUFFERS, DeleteBuffers)                                                                                      \
  X(DELETEFRAMEBUFFERS, DeleteFramebuffers)                                                                            \
  X(DELETEPROGRAM, DeleteProgram)                                                                                      \
  X(DELETESAMPLERS, DeleteSamplers)                                                                                    \
  X(DELETESHADER, DeleteShader)                                                                                        \
  X(DELETETEXTURES, DeleteTextures)                                                                                    \
  X(DELETEVERTEXARRAYS, DeleteVertexArrays)                                                                            \
  X(DEPTHFUNC, DepthFunc)                                                                                              \
  X(DEPTHMASK, DepthMask)                                                                                              \
  X(DISABLE, Disable)                                                                                                  \
  X(DISABLEVERTEXARRAYATTRIB, DisableVertexArrayAttrib)                                                                \
  X(DRAWARRAYS, DrawArrays)                                                                                            \
  X(DRAWELEMENTS, DrawElements)                                                                                        \
  X(ENABLE, Enable)                                                                                                    \
  X(ENABLEVERTEXARRAYATTRIB, EnableVertexArrayAttrib)                                                                  \
  X(FINISH, Finish)                                                                                                    \
  X(GENERATETEXTUREMIPMAP, GenerateTextureMipmap)                                                                      \
  X(GETERROR, GetError)                                                                                                \
  X(GETINTEGERV, GetIntegerv)                                                                                          \
  X(GETPROGRAMINFOLOG, GetProgramInfoLog)                                                                              \
  X(GETPROGRAMIV, GetProgramiv)                                                                                        \
  X(GETSHADERINFOLOG, GetShaderInfoLog)                                                                                \
  X(GETSHADERIV, GetShaderiv)                                                                                          \
  X(GETSTRING, GetString)                                                                                              \
  X(GETTEXTUREIMAGE, GetTextureImage)                                                                                  \
  X(GETUNIFORMLOCATION, GetUniformLocation)                                                                            \
  X(LINKPROGRAM, LinkProgram)                                                                                          \
  X(NAMEDBUFFERDATA, NamedBufferData)                                                                                  \
  X(NAMEDFRAMEBUFFERDRAWBUFFER, NamedFramebufferDrawBuffer)                                                            \
  X(NAMEDFRAMEBUFFERTEXTURE, NamedFramebufferTexture)                                                                  \
  X(PIXELSTOREI, PixelStorei)                                                                                          \
  X(SAMPLERPARAMETERI, SamplerParameteri)                                                                              \
  X(SCISSOR, Scissor)                                                                                                  \
  X(SHADERSOURCE, ShaderSource)                                                                                        \
  X(TEXTUREPARAMETERFV, TextureParameterfv)                                                                            \
  X(TEXTUREPARAMETERI, TextureParameteri)                                                                              \
  X(TEXTURESTORAGE2D, TextureStorage2D)                                                                                \
  X(TEXTURESUBIMAGE2D, TextureSubImage2D)                                                                              \
  X(UNIFORM1F, Uniform1f)                                                                                              \
  X(UNIFORM1I, Uniform1i)                                                                                              \
  X(UNIFORM2F, Uniform2f)                                                                                              \
  X(UNIFORM3F, Uniform3f)                                                                                              \
  X(UNIFORM4FV, Uniform4fv)                                                                                            \
  X(UNIFORMMATRIX4FV, UniformMatrix4fv)                                                                                \
  X(USEPROGRAM, UseProgram)                                                                                            \
  X(VERTEXARRAYATTRIBBINDING, VertexArrayAttribBinding)                                                                \
  X(VERTEXARRAYATTRIBFORMAT, VertexArrayAttribFormat)                                                                  \
  X(VERTEXARRAYATTRIBIFORMAT, VertexArrayAttribIFormat)                                                                \
  X(VERTEXARRAYELEMENTBUFFER, VertexArrayElementBuffer)                                                                \
  X(VERTEXARRAYVERTEXBUFFER, VertexArrayVertexBuffer)                                                                  \
  X(VIEWPORT, Viewport)

namespace wry::render {

/// The OpenGL 4.5 core functions of one context. libGL is never linked: it would hide OSMesa's own.
struct GlFunctions {
#define WRY_GL_MEMBER(type, name) PFNGL##type##PROC name = nullptr;
  WRY_GL_FUNCTIONS(WRY_GL_MEMBER)
#undef WRY_GL_MEMBER
};

/// Looks every function up. Error: unavailable, naming the first function that is missing.
Result<GlFunctions> load_gl_functions(const std::function<void*(const char*)>& look_up);

} // namespace wry::render
