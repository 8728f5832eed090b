# SPDX-License-Identifier: MIT
# Completion of `fanal` for bash. It asks the program itself, so that it never falls behind.

_fanal_options() { "$1" "$2" --help 2>/dev/null | grep -oE -- '(^|[ ,])--[a-z][a-z-]*' | tr -d ' ,' | sort -u; }

# Lines "key=default" and, indented, "takes: a, b, c" of `fanal render --options`.
_fanal_keys() { "$1" render --options 2>/dev/null | sed -nE 's/^([a-z][a-z0-9.-]*)=.*/\1=/p'; }
_fanal_values() {
    "$1" render --options 2>/dev/null | awk -v key="$2" '
        /^[a-z]/ { found = index($0, key "=") == 1 }
        found && sub(/^    takes: /, "") && !/\.\./ { gsub(/, | or /, "\n"); sub(/ [a-z]+$/, ""); print }' | grep -E '^[a-z0-9.-]+$'
}

# The key of an option with a name of its own.
_fanal_key_of() {
    case $1 in
    --cull) echo culling ;;
    --gbuffer) echo gbuffer.layout ;;
    --msaa-method) echo deferred.msaa-method ;;
    --stereo-path) echo stereo.path ;;
    --shading | --lists | --msaa | --transparency | --decals | --aa | --geometry | --occlusion | --tonemap | --debug) echo "${1#--}" ;;
    esac
}

_fanal() {
    local program=${COMP_WORDS[0]} command=${COMP_WORDS[1]-} line=${COMP_LINE:0:COMP_POINT} current previous key
    local commands="render view xr cave trace bench info devices compare compress"
    local scenes="city hall interior wall room spheres pole lamps grass onetile nearplane sky glass"
    # Bash parts words at "=": take the word under the cursor whole.
    current=${line##*[ ]}
    previous=${line%"$current"}
    previous=${previous%"${previous##*[! ]}"}
    previous=${previous##* }
    COMPREPLY=()
    if [ "$COMP_CWORD" -le 1 ]; then
        COMPREPLY=($(compgen -W "$commands help version --help --version" -- "$current") $(compgen -f -X '!*.gl[tb]*' -- "$current"))
        [[ $current != builtin:* ]] || COMPREPLY=($(compgen -W "$scenes" -- "${current#builtin:}")) # bash parts words at ":" too
        return
    fi
    if [ "$command" = help ]; then
        COMPREPLY=($(compgen -W "$commands" -- "$current"))
        return
    fi
    key=$(_fanal_key_of "$previous")
    if [ "$previous" = --set ] || [ "$previous" = --vary ]; then
        if [[ $current == *=* ]]; then
            key=${current%%=*}
            COMPREPLY=($(compgen -W "$(_fanal_values "$program" "$key") $([ "$previous" = --vary ] && echo all)" -- "${current#*=}"))
        else
            COMPREPLY=($(compgen -W "$(_fanal_keys "$program")" -- "$current"))
            compopt -o nospace 2>/dev/null
        fi
    elif [ -n "$key" ] && [[ $current != -* ]]; then
        COMPREPLY=($(compgen -W "$(_fanal_values "$program" "$key")" -- "$current"))
    elif [[ $current == -* ]]; then
        COMPREPLY=($(compgen -W "$(_fanal_options "$program" "$command")" -- "$current"))
    elif [[ $previous == --displays && $current == builtin:* ]]; then
        COMPREPLY=($(compgen -W "mono stereo three cave" -- "${current#builtin:}"))
    elif [[ $current == builtin:* ]]; then
        COMPREPLY=($(compgen -W "$scenes" -- "${current#builtin:}")) # bash parts words at ":" too
    else
        COMPREPLY=($(compgen -f -- "$current"))
        [[ $command != render && $command != view && $command != xr && $command != cave && $command != trace && $command != bench && $command != info ]] || COMPREPLY+=($(compgen -W "builtin:" -- "$current"))
    fi
}
complete -o filenames -F _fanal fanal
