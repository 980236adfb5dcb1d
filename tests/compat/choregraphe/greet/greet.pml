<?xml version="1.0" encoding="UTF-8" ?>
<Package name="greet" format_version="4">
    <BehaviorDescriptions>
        <BehaviorDescription name="behavior" src="behavior_1" xar="behavior.xar" />
    </BehaviorDescriptions>
    <Dialogs />
    <Resources />
</Package>
