# SPDX-License-Identifier: MIT
# Completion of `fanal` for fish. It asks the program itself, so that it never falls behind.

function __fanal_values
    fanal render --options 2>/dev/null | awk -v key="$argv[1]" '
        /^[a-z]/ { found = index($0, key "=") == 1 }
        found && sub(/^    takes: /, "") && !/\.\./ { gsub(/, | or /, "\n"); sub(/ [a-z]+$/, ""); print }' | grep -E '^[a-z0-9.-]+$'
end

function __fanal_settings
    set -l current (commandline -ct)
    if string match -q '*=*' -- $current
        set -l key (string split -m 1 = -- $current)[1]
        for value in (__fanal_values $key)
            echo $key=$value
        end
    else
        fanal render --options 2>/dev/null | sed -nE 's/^([a-z][a-z0-9.-]*)=.*/\1=/p'
    end
end

function __fanal_options
    fanal (commandline -opc)[2] --help 2>/dev/null | grep -oE -- '(^|[ ,])--[a-z][a-z-]*' | tr -d ' ,' | sort -u
end

complete -c fanal -n __fish_use_subcommand -a 'render view xr cave trace bench info devices compare compress help version'
complete -c fanal -n '__fish_seen_subcommand_from help' -f -a 'render view xr cave trace bench info devices compare compress'
complete -c fanal -n 'not __fish_use_subcommand; and string match -q -- "-*" (commandline -ct)' -f -a '(__fanal_options)'
complete -c fanal -n '__fish_seen_subcommand_from render view xr cave trace bench info' -a 'builtin:city builtin:hall builtin:interior builtin:wall builtin:room builtin:spheres builtin:pole builtin:lamps builtin:grass builtin:onetile builtin:nearplane builtin:sky builtin:glass'
complete -c fanal -n '__fish_seen_subcommand_from render cave bench' -l set -x -a '(__fanal_settings)'
complete -c fanal -n '__fish_seen_subcommand_from cave' -l displays -r -a 'builtin:mono builtin:stereo builtin:three builtin:cave'
complete -c fanal -n '__fish_seen_subcommand_from bench' -l vary -x -a '(__fanal_settings)'
for pair in shading:shading lists:lists msaa:msaa transparency:transparency decals:decals aa:aa geometry:geometry cull:culling \
        gbuffer:gbuffer.layout msaa-method:deferred.msaa-method tonemap:tonemap debug:debug
    set -l both (string split : $pair)
    complete -c fanal -n '__fish_seen_subcommand_from render cave bench' -l $both[1] -x -a "(__fanal_values $both[2])"
end
