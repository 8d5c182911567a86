# Heavy headers of others are parsed once per kind of target instead of once per source: a third of the build's time.
# Sources still include what they use; -DVOXNAV_PRECOMPILED_HEADERS=OFF shows one that does not.
option(VOXNAV_PRECOMPILED_HEADERS "Parse the headers of the libraries used once per kind of target" ON)

# voxnav_precompile(target header...)
function(voxnav_precompile target)
  if(VOXNAV_PRECOMPILED_HEADERS)
    # Definitions that differ between targets would keep them from sharing.
    set_target_properties(${target} PROPERTIES DEFINE_SYMBOL "")
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# voxnav_share_precompiled(target owner): the headers that the owner precompiled, with the same options.
function(voxnav_share_precompiled target owner)
  if(VOXNAV_PRECOMPILED_HEADERS)
    set_target_properties(${target} PROPERTIES DEFINE_SYMBOL "")
    target_precompile_headers(${target} REUSE_FROM ${owner})
  endif()
endfunction()
